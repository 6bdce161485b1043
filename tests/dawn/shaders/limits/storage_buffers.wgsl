// Dawn: refuses it: The number of storage buffers (9) in the Fragment stage exceeds the maximum per-stage limit (8).
// Umbrage: maxStorageBuffersPerShaderStage
@group(0) @binding(0) var<storage> u0: vec4f;
@group(0) @binding(1) var<storage> u1: vec4f;
@group(0) @binding(2) var<storage> u2: vec4f;
@group(0) @binding(3) var<storage> u3: vec4f;
@group(0) @binding(4) var<storage> u4: vec4f;
@group(0) @binding(5) var<storage> u5: vec4f;
@group(0) @binding(6) var<storage> u6: vec4f;
@group(0) @binding(7) var<storage> u7: vec4f;
@group(0) @binding(8) var<storage> u8: vec4f;
@fragment fn fs() -> @location(0) vec4f {
    var sum = vec4f();
    sum += u0;
    sum += u1;
    sum += u2;
    sum += u3;
    sum += u4;
    sum += u5;
    sum += u6;
    sum += u7;
    sum += u8;
    return sum;
}

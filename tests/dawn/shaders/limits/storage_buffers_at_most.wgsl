// Dawn: takes it
@group(0) @binding(0) var<storage> u0: vec4f;
@group(0) @binding(1) var<storage> u1: vec4f;
@group(0) @binding(2) var<storage> u2: vec4f;
@group(0) @binding(3) var<storage> u3: vec4f;
@group(0) @binding(4) var<storage> u4: vec4f;
@group(0) @binding(5) var<storage> u5: vec4f;
@group(0) @binding(6) var<storage> u6: vec4f;
@group(0) @binding(7) var<storage> u7: vec4f;
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
    return sum;
}

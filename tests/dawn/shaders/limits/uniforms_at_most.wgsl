// Dawn: takes it
@group(0) @binding(0) var<uniform> u0: vec4f;
@group(0) @binding(1) var<uniform> u1: vec4f;
@group(0) @binding(2) var<uniform> u2: vec4f;
@group(0) @binding(3) var<uniform> u3: vec4f;
@group(0) @binding(4) var<uniform> u4: vec4f;
@group(0) @binding(5) var<uniform> u5: vec4f;
@group(0) @binding(6) var<uniform> u6: vec4f;
@group(0) @binding(7) var<uniform> u7: vec4f;
@group(0) @binding(8) var<uniform> u8: vec4f;
@group(0) @binding(9) var<uniform> u9: vec4f;
@group(0) @binding(10) var<uniform> u10: vec4f;
@group(0) @binding(11) var<uniform> u11: vec4f;
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
    sum += u9;
    sum += u10;
    sum += u11;
    return sum;
}

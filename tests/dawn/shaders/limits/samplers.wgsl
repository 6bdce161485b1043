// Dawn: refuses it: The number of samplers (17) in the Fragment stage exceeds the maximum per-stage limit (16).
// Umbrage: maxSamplersPerShaderStage
@group(0) @binding(30) var t: texture_2d<f32>;
@group(0) @binding(0) var s0: sampler;
@group(0) @binding(1) var s1: sampler;
@group(0) @binding(2) var s2: sampler;
@group(0) @binding(3) var s3: sampler;
@group(0) @binding(4) var s4: sampler;
@group(0) @binding(5) var s5: sampler;
@group(0) @binding(6) var s6: sampler;
@group(0) @binding(7) var s7: sampler;
@group(0) @binding(8) var s8: sampler;
@group(0) @binding(9) var s9: sampler;
@group(0) @binding(10) var s10: sampler;
@group(0) @binding(11) var s11: sampler;
@group(0) @binding(12) var s12: sampler;
@group(0) @binding(13) var s13: sampler;
@group(0) @binding(14) var s14: sampler;
@group(0) @binding(15) var s15: sampler;
@group(0) @binding(16) var s16: sampler;
@fragment fn fs() -> @location(0) vec4f {
    var sum = vec4f();
    sum += textureSampleLevel(t, s0, vec2f(), 0.0);
    sum += textureSampleLevel(t, s1, vec2f(), 0.0);
    sum += textureSampleLevel(t, s2, vec2f(), 0.0);
    sum += textureSampleLevel(t, s3, vec2f(), 0.0);
    sum += textureSampleLevel(t, s4, vec2f(), 0.0);
    sum += textureSampleLevel(t, s5, vec2f(), 0.0);
    sum += textureSampleLevel(t, s6, vec2f(), 0.0);
    sum += textureSampleLevel(t, s7, vec2f(), 0.0);
    sum += textureSampleLevel(t, s8, vec2f(), 0.0);
    sum += textureSampleLevel(t, s9, vec2f(), 0.0);
    sum += textureSampleLevel(t, s10, vec2f(), 0.0);
    sum += textureSampleLevel(t, s11, vec2f(), 0.0);
    sum += textureSampleLevel(t, s12, vec2f(), 0.0);
    sum += textureSampleLevel(t, s13, vec2f(), 0.0);
    sum += textureSampleLevel(t, s14, vec2f(), 0.0);
    sum += textureSampleLevel(t, s15, vec2f(), 0.0);
    sum += textureSampleLevel(t, s16, vec2f(), 0.0);
    return sum;
}

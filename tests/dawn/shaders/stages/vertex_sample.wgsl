// Dawn: refuses it: built-in cannot be used by vertex pipeline stage
// Umbrage: uses operations forbidden at this stage
@group(0) @binding(0) var t: texture_2d<f32>;
@group(0) @binding(1) var s: sampler;
@vertex fn vs() -> @builtin(position) vec4f {
    return vec4f(textureSample(t, s, vec2f()));
}

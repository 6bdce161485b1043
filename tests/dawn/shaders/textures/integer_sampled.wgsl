// Dawn: refuses it: no matching call to 'textureSample(texture_2d<u32>, sampler, vec2<f32>)'
// Umbrage: unable to operate on image class sampled
@group(0) @binding(0) var t: texture_2d<u32>;
@group(0) @binding(1) var s: sampler;
@fragment fn fs(@builtin(position) at: vec4f) -> @location(0) vec4f {
    return vec4f(textureSample(t, s, at.xy));
}

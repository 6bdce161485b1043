// Dawn: refuses it: the 'offset' argument of 'textureSample' must be a const-expression
// Umbrage: this operation is not supported in a const context
@group(0) @binding(0) var t: texture_2d<f32>;
@group(0) @binding(1) var s: sampler;
@group(0) @binding(2) var d: texture_depth_2d;
@group(0) @binding(3) var c: sampler_comparison;
@fragment fn fs(@builtin(position) at: vec4f) -> @location(0) vec4f {
    let offset = vec2i(1, 0);
    return textureSample(t, s, at.xy, offset);
}

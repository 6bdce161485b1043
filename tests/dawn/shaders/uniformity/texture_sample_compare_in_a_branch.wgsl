// Dawn: refuses it: 'textureSampleCompare' must only be called from uniform control flow
// Umbrage: `textureSampleCompare` must only be called from uniform control flow
@group(0) @binding(0) var depths: texture_depth_2d;
@group(0) @binding(1) var compares: sampler_comparison;
@fragment fn fs(@location(0) x: f32, @location(1) uv: vec2f) -> @location(0) vec4f {
    if x > 0.5 {
        return vec4f(textureSampleCompare(depths, compares, uv, 0.5));
    }
    return vec4f();
}

// Dawn: refuses it: expected severity control
// Umbrage: invalid diagnostic severity
diagnostic(never, derivative_uniformity);
@group(0) @binding(0) var image: texture_2d<f32>;
@group(0) @binding(1) var at_rest: sampler;
@fragment fn fs(@location(0) x: f32, @location(1) uv: vec2f) -> @location(0) vec4f {
    if x > 0.5 {
        return textureSample(image, at_rest, uv);
    }
    return vec4f();
}

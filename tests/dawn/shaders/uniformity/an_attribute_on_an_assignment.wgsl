// Dawn: refuses it: unexpected attributes
// Umbrage: may not stand here
@group(0) @binding(0) var image: texture_2d<f32>;
@group(0) @binding(1) var at_rest: sampler;
@fragment fn fs(@location(0) x: f32, @location(1) uv: vec2f) -> @location(0) vec4f {
    var y = x;
    @diagnostic(off, derivative_uniformity) y = 2.0;
    return vec4f(y);
}

// Dawn: takes it
@group(0) @binding(0) var image: texture_2d<f32>;
@group(0) @binding(1) var at_rest: sampler;
@fragment fn fs(@location(0) x: f32, @location(1) uv: vec2f) -> @location(0) vec4f {
    switch i32(x) @diagnostic(off, derivative_uniformity) {
        case 0: {
            return textureSample(image, at_rest, uv);
        }
        default: {
            return vec4f();
        }
    }
}

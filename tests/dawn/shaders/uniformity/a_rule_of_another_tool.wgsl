// Dawn: takes it
@group(0) @binding(0) var image: texture_2d<f32>;
@group(0) @binding(1) var at_rest: sampler;
@fragment fn fs(@location(0) x: f32, @location(1) uv: vec2f) -> @location(0) vec4f {
    @diagnostic(off, tool.rule)
    if x > 0.5 {
        return vec4f(1.0);
    }
    return vec4f();
}

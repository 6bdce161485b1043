// Dawn: takes it
@fragment fn fs(@location(3) @interpolate(flat, either) a: vec2u, @location(1) @interpolate(linear, sample) b: f32) -> @location(0) vec4f {
    return vec4f(f32(a.x), b, 0.0, 0.0);
}

// Dawn: takes it
@fragment fn fs() -> @location(0) @interpolate(flat) vec4f {
    return vec4f();
}

// Dawn: takes it
@fragment fn fs() -> @location(7) vec4f {
    return vec4f();
}

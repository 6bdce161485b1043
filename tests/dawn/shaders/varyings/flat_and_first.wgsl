// Dawn: takes it
struct Given {
    @location(0) @interpolate(flat) a: f32,
    @builtin(position) position: vec4f,
}
@vertex fn vs() -> Given {
    var given: Given;
    return given;
}
@fragment fn fs(@location(0) @interpolate(flat, first) a: f32) -> @location(0) vec4f {
    return vec4f();
}

// Dawn: takes it
struct Given {
    @location(0) a: vec2f,
    @builtin(position) position: vec4f,
}
@vertex fn vs() -> Given {
    var given: Given;
    return given;
}
@fragment fn fs(@location(0) a: vec2f) -> @location(0) vec4f {
    return vec4f();
}

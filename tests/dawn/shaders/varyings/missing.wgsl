// Dawn: refuses it: The fragment input at location 1 doesn't have a corresponding vertex output.
// Umbrage: location 1
struct Given {
    @location(0) a: vec2f,
    @builtin(position) position: vec4f,
}
@vertex fn vs() -> Given {
    var given: Given;
    return given;
}
@fragment fn fs(@location(1) a: vec2f) -> @location(0) vec4f {
    return vec4f();
}

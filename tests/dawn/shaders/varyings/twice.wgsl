// Dawn: refuses it: '@location(0)' appears multiple times
// Umbrage: multiple bindings at location 0 are present
struct Given {
    @location(0) a: f32,
    @location(0) b: f32,
    @builtin(position) position: vec4f,
}
@vertex fn vs() -> Given {
    var given: Given;
    return given;
}
@fragment fn fs(@location(0) a: f32) -> @location(0) vec4f {
    return vec4f();
}

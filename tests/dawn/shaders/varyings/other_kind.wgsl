// Dawn: refuses it: The base type (u32) of the vertex output at location 0 is different from the base type (i32) of the fragment input at location 0.
// Umbrage: location 0
struct Given {
    @location(0) @interpolate(flat) a: u32,
    @builtin(position) position: vec4f,
}
@vertex fn vs() -> Given {
    var given: Given;
    return given;
}
@fragment fn fs(@location(0) @interpolate(flat) a: i32) -> @location(0) vec4f {
    return vec4f();
}

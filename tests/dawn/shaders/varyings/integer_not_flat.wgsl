// Dawn: refuses it: integral user-defined vertex outputs must have a '@interpolate(flat)' attribute
// Umbrage: `@interpolate(flat) must be explicitly specified for integer i/o
struct Given {
    @location(0) a: u32,
    @builtin(position) position: vec4f,
}
@vertex fn vs() -> Given {
    var given: Given;
    return given;
}
@fragment fn fs(@location(0) a: u32) -> @location(0) vec4f {
    return vec4f();
}

// Dawn: refuses it: The interpolation type (Flat) of the vertex output at location 0 is different from the interpolation type (Perspective) of the fragment input at location 0.
// Umbrage: interpolated
struct Given {
    @location(0) @interpolate(flat) a: f32,
    @builtin(position) position: vec4f,
}
@vertex fn vs() -> Given {
    var given: Given;
    return given;
}
@fragment fn fs(@location(0) a: f32) -> @location(0) vec4f {
    return vec4f();
}

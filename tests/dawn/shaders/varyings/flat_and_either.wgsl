// Dawn: refuses it: The interpolation sampling (First) of the vertex output at location 0 is different from the interpolation sampling (Either) of the fragment input at location 0.
// Umbrage: interpolated
struct Given {
    @location(0) @interpolate(flat) a: f32,
    @builtin(position) position: vec4f,
}
@vertex fn vs() -> Given {
    var given: Given;
    return given;
}
@fragment fn fs(@location(0) @interpolate(flat, either) a: f32) -> @location(0) vec4f {
    return vec4f();
}

// Dawn: refuses it: The interpolation sampling (Center) of the vertex output at location 0 is different from the interpolation sampling (Centroid) of the fragment input at location 0.
// Umbrage: interpolated
struct Given {
    @location(0) @interpolate(perspective) a: f32,
    @builtin(position) position: vec4f,
}
@vertex fn vs() -> Given {
    var given: Given;
    return given;
}
@fragment fn fs(@location(0) @interpolate(perspective, centroid) a: f32) -> @location(0) vec4f {
    return vec4f();
}

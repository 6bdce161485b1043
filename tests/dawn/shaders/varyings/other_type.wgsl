// Dawn: refuses it: The component count (2) of the vertex output at location 0 is different from the component count (3) of the fragment input at location 0.
// Umbrage: location 0
struct Given {
    @location(0) a: vec2f,
    @builtin(position) position: vec4f,
}
@vertex fn vs() -> Given {
    var given: Given;
    return given;
}
@fragment fn fs(@location(0) a: vec3f) -> @location(0) vec4f {
    return vec4f();
}

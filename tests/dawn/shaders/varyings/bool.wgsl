// Dawn: refuses it: cannot apply '@location' to declaration of type 'bool'
// Umbrage: a `bool` cannot go in or out of a stage: numbers and vectors of them alone can
struct Given {
    @location(0) @interpolate(flat) a: bool,
    @builtin(position) position: vec4f,
}
@vertex fn vs() -> Given {
    var given: Given;
    return given;
}
@fragment fn fs(@location(0) @interpolate(flat) a: bool) -> @location(0) vec4f {
    return vec4f();
}

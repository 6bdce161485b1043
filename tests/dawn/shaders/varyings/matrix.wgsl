// Dawn: refuses it: cannot apply '@location' to declaration of type 'mat2x2<f32>'
// Umbrage: a `mat2x2<f32>` cannot go in or out of a stage: numbers and vectors of them alone can
struct Given {
    @location(0) a: mat2x2f,
    @builtin(position) position: vec4f,
}
@vertex fn vs() -> Given {
    var given: Given;
    return given;
}
@fragment fn fs(@location(0) a: mat2x2f) -> @location(0) vec4f {
    return vec4f();
}

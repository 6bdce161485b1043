// Dawn: refuses it: var with 'storage' address space and 'read_write' access mode cannot be used by vertex pipeline stage
// Umbrage: the vertex stage
@group(0) @binding(0) var<storage, read_write> s: array<f32>;
fn f() -> f32 {
    return s[0];
}
@vertex fn vs() -> @builtin(position) vec4f {
    return vec4f(f());
}

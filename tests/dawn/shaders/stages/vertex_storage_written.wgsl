// Dawn: refuses it: var with 'storage' address space and 'read_write' access mode cannot be used by vertex pipeline stage
// Umbrage: the vertex stage `vs` uses the storage buffer `s`
@group(0) @binding(0) var<storage, read_write> s: array<f32>;
@vertex fn vs() -> @builtin(position) vec4f {
    return vec4f(s[0]);
}

// Dawn: refuses it: Binding size (134217744) of [Buffer (unlabeled)] is larger than the maximum storage buffer binding size (134217728).
// Umbrage: maxStorageBufferBindingSize
@group(0) @binding(0) var<storage> u: array<vec4f, 8388609>;
@fragment fn fs() -> @location(0) vec4f {
    return u[0];
}

// Dawn: refuses it: Binding size (65552) of [Buffer (unlabeled)] is larger than the maximum uniform buffer binding size (65536).
// Umbrage: maxUniformBufferBindingSize
@group(0) @binding(0) var<uniform> u: array<vec4f, 4097>;
@fragment fn fs() -> @location(0) vec4f {
    return u[0];
}

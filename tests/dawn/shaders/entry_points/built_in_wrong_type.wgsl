// Dawn: refuses it: store type of '@builtin(local_invocation_index)' must be 'u32'
// Umbrage: `@builtin(local_invocation_index)` cannot be of the type `f32`
@compute @workgroup_size(1) fn cs(@builtin(local_invocation_index) i: f32) {}

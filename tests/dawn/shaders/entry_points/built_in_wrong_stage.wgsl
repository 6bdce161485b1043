// Dawn: refuses it: '@builtin(vertex_index)' cannot be used for fragment shader input
// Umbrage: `@builtin(vertex_index)` is not to be had in this stage, or not in this direction
@fragment fn fs(@builtin(vertex_index) i: u32) {}

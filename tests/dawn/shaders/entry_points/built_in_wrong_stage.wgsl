// Dawn: refuses it: '@builtin(vertex_index)' cannot be used for fragment shader input
@fragment fn fs(@builtin(vertex_index) i: u32) {}

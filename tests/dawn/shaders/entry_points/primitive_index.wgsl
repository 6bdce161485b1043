// Dawn: refuses it: extension 'primitive_index' is not allowed in the current environment
// Umbrage: the built-in value `primitive_index` is none of WGSL's, and what some devices offer beyond it modules cannot ask for
enable primitive_index;
@fragment fn fs(@builtin(primitive_index) i: u32) {}

// Dawn: refuses it: extension 'primitive_index' is not allowed in the current environment
enable primitive_index;
@fragment fn fs(@builtin(primitive_index) i: u32) {}

// Dawn: refuses it: missing entry point IO attribute on parameter
@fragment fn fs(a: f32) {}

// Dawn: refuses it: missing entry point IO attribute on parameter
// Umbrage: entry point arguments and return values must all have bindings
@fragment fn fs(a: f32) {}

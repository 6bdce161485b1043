// Dawn: refuses it: '@location(0)' appears multiple times
// Umbrage: multiple bindings at location 0 are present
@fragment fn fs(@location(0) a: f32, @location(0) b: f32) {}

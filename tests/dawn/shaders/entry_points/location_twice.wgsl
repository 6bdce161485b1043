// Dawn: refuses it: '@location(0)' appears multiple times
@fragment fn fs(@location(0) a: f32, @location(0) b: f32) {}

// Dawn: refuses it: 'first' and 'either' sampling parameters can only be used with flat interpolation
// Umbrage: cannot combine linear interpolation with the first sample type
@fragment fn fs(@location(0) @interpolate(linear, first) a: f32) {}

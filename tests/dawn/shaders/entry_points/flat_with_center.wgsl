// Dawn: refuses it: flat interpolation can only use 'first' and 'either' sampling parameters
@fragment fn fs(@location(0) @interpolate(flat, center) a: f32) {}

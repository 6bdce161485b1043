// Dawn: refuses it: flat interpolation can only use 'first' and 'either' sampling parameters
// Umbrage: cannot combine flat interpolation with the center sample type
@fragment fn fs(@location(0) @interpolate(flat, center) a: f32) {}

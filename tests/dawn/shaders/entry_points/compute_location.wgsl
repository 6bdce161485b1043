// Dawn: refuses it: '@location' cannot be used by compute shaders
// Umbrage: built-in inputs
@compute @workgroup_size(1) fn cs(@location(0) a: f32) {}

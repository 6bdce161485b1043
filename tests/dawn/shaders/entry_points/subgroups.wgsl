// Dawn: refuses it: extension 'subgroups' is not allowed in the current environment
// Umbrage: this needs subgroup operations, which the target `webgpu` does not offer
enable subgroups;
@compute @workgroup_size(1) fn cs(@builtin(subgroup_size) s: u32) {}

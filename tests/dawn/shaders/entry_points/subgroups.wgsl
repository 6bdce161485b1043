// Dawn: refuses it: extension 'subgroups' is not allowed in the current environment
enable subgroups;
@compute @workgroup_size(1) fn cs(@builtin(subgroup_size) s: u32) {}

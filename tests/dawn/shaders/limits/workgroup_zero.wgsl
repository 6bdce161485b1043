// Dawn: refuses it: '@workgroup_size' argument must be at least 1
@compute @workgroup_size(0) fn cs() {}

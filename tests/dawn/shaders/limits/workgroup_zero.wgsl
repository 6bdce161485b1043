// Dawn: refuses it: '@workgroup_size' argument must be at least 1
// Umbrage: `cs` has workgroups of the size 0 along x
@compute @workgroup_size(0) fn cs() {}

// Dawn: refuses it: An error occurred while running Null writer
// Umbrage: a size of 1
override n = 0;
@compute @workgroup_size(n) fn cs() {}

// Dawn: takes it
@compute @workgroup_size(1, 1, 64) fn cs() {}

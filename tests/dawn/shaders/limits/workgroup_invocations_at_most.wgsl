// Dawn: takes it
@compute @workgroup_size(16, 16) fn cs() {}

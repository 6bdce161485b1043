// Dawn: takes it
override n = 64;
@compute @workgroup_size(n, 4) fn cs() {}

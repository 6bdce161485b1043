// Dawn: takes it
@id(65535) override n: u32 = 1u;
@compute @workgroup_size(n) fn cs() {}

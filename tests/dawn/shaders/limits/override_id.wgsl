// Dawn: refuses it: '@id' value must be between 0 and 65535
@id(65536) override n: u32 = 1u;
@compute @workgroup_size(n) fn cs() {}

// Dawn: refuses it: '@id' values must be unique
@id(1) override n: u32 = 1u;
@id(1) override m: u32 = 1u;
@compute @workgroup_size(n, m) fn cs() {}

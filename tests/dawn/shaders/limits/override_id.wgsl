// Dawn: refuses it: '@id' value must be between 0 and 65535
// Umbrage: pipeline constant ID must be between 0 and 65535 inclusive
@id(65536) override n: u32 = 1u;
@compute @workgroup_size(n) fn cs() {}

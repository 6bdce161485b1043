// Dawn: refuses it: '@id' values must be unique
// Umbrage: `demo::main` has two overrides `@id(1)`, and a host that sets it sets one alone
@id(1) override n: u32 = 1u;
@id(1) override m: u32 = 1u;
@compute @workgroup_size(n, m) fn cs() {}

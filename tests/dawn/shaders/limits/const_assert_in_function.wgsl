// Dawn: refuses it: const assertion failed
// Umbrage: `const_assert` failure
@compute @workgroup_size(1) fn cs() {
    const_assert 1 > 2;
}

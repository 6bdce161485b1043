// Dawn: refuses it: const assertion failed
@compute @workgroup_size(1) fn cs() {
    const_assert 1 > 2;
}

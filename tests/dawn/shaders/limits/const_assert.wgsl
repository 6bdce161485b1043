// Dawn: refuses it: const assertion failed
// Umbrage: `const_assert` failure
const A = 3;
const_assert A < 3;
@compute @workgroup_size(1) fn cs() {
    let r = A;
}

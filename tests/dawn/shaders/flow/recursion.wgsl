// Dawn: refuses it: cyclic dependency found: 'f' -> 'f'
// Umbrage: declaration of `f` is recursive
fn f() {
    f();
}
@compute @workgroup_size(1) fn cs() {
    f();
}

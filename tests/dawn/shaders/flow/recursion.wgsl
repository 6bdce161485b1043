// Dawn: refuses it: cyclic dependency found: 'f' -> 'f'
fn f() {
    f();
}
@compute @workgroup_size(1) fn cs() {
    f();
}

// Dawn: refuses it: invalid aliased pointer argument
// Umbrage: an argument of `f` points into `w`, which it uses by name as well, and it writes by one of the two
var<workgroup> w: array<i32, 4>;
fn f(a: ptr<workgroup, i32>) {
    *a = w[1];
}
@compute @workgroup_size(1) fn cs() {
    f(&w[0]);
}

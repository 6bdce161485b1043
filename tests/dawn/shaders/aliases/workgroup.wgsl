// Dawn: refuses it: invalid aliased pointer argument
var<workgroup> w: array<i32, 4>;
fn f(a: ptr<workgroup, i32>) {
    *a = w[1];
}
@compute @workgroup_size(1) fn cs() {
    f(&w[0]);
}

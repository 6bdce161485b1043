// Dawn: refuses it: invalid aliased pointer argument
// Umbrage: point into `x`
fn r(a: ptr<function, i32>) -> i32 {
    return *a;
}
fn f(a: ptr<function, i32>, b: ptr<function, i32>) {
    *a = r(b);
}
@compute @workgroup_size(1) fn cs() {
    var x = 1;
    f(&x, &x);
}

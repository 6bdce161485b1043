// Dawn: refuses it: invalid aliased pointer argument
// Umbrage: point into `x`
fn f(a: ptr<function, i32>, b: ptr<function, i32>, c: ptr<function, i32>) {
    *a = *c;
}
@compute @workgroup_size(1) fn cs() {
    var x = 1;
    var y = 1;
    f(&x, &y, &x);
}

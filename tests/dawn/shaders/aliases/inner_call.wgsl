// Dawn: refuses it: invalid aliased pointer argument
// Umbrage: `f`
fn f(a: ptr<function, i32>, b: ptr<function, i32>) {
    *a = *b;
}
fn g(a: ptr<function, i32>) {
    f(a, a);
}
@compute @workgroup_size(1) fn cs() {
    var x = 1;
    g(&x);
}

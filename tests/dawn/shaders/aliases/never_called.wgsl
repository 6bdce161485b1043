// Dawn: refuses it: invalid aliased pointer argument
// Umbrage: `f`
fn f(a: ptr<function, i32>, b: ptr<function, i32>) {
    *a = *b;
}
fn g() {
    var x = 1;
    f(&x, &x);
}
@compute @workgroup_size(1) fn cs() {

}

// Dawn: refuses it: invalid aliased pointer argument
// Umbrage: point into `a`
fn f(a: ptr<function, i32>, b: ptr<function, i32>) {
    *a = *b;
}
@compute @workgroup_size(1) fn cs() {
    var x = vec2i();
    var a = array<i32, 2>();
    f(&a[0], &a[1]);
}

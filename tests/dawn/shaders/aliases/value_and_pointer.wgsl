// Dawn: takes it
fn f(a: ptr<function, i32>, b: i32) {
    *a = b;
}
@compute @workgroup_size(1) fn cs() {
    var x = 1;
    f(&x, x);
}

// Dawn: takes it
fn f(a: ptr<function, i32>, b: ptr<function, i32>) {
    *a = 1;
}
@compute @workgroup_size(1) fn cs() {
    var x = 1;
    f(&x, &x);
}

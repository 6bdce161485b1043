// Dawn: takes it
fn f(a: ptr<function, i32>, b: ptr<function, i32>) -> i32 {
    return *a + *b;
}
@compute @workgroup_size(1) fn cs() {
    var x = 1;
    let r = f(&x, &x);
}

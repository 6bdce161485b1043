// Dawn: refuses it: invalid aliased pointer argument
// Umbrage: point into `x`
fn f(a: ptr<function, i32>, b: ptr<function, i32>) {
    *a = *b;
}
@compute @workgroup_size(1) fn cs() {
    var x = 1;
    for (var i = 0; i < 3; i++) {
        if i == 1 {
            f(&x, &x);
        }
    }
}

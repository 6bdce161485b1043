// Dawn: takes it
var<private> v: i32;
fn f(a: ptr<function, i32>) {
    *a = v;
}
@compute @workgroup_size(1) fn cs() {
    var x = 1;
    f(&x);
}

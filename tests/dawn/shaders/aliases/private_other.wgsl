// Dawn: takes it
var<private> v: i32;
var<private> w: i32;
fn f(a: ptr<private, i32>) {
    *a = w;
}
@compute @workgroup_size(1) fn cs() {
    f(&v);
}

// Dawn: takes it
var<private> v: i32;
fn f(a: ptr<private, i32>) -> i32 {
    return *a + v;
}
@compute @workgroup_size(1) fn cs() {
    let r = f(&v);
}

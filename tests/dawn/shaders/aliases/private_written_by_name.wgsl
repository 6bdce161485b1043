// Dawn: refuses it: invalid aliased pointer argument
// Umbrage: uses by name
var<private> v: i32;
fn f(a: ptr<private, i32>) -> i32 {
    v = 2;
    return *a;
}
@compute @workgroup_size(1) fn cs() {
    let r = f(&v);
}

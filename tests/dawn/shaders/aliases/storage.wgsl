// Dawn: refuses it: invalid aliased pointer argument
// Umbrage: an argument of `f` points into `s`, which it uses by name as well, and it writes by one of the two
@group(0) @binding(0) var<storage, read_write> s: array<i32>;
fn f(a: ptr<storage, i32, read_write>) {
    *a = s[1];
}
@compute @workgroup_size(1) fn cs() {
    f(&s[0]);
}

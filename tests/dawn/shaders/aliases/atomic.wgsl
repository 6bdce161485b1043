// Dawn: refuses it: invalid aliased pointer argument
// Umbrage: uses by name
var<workgroup> w: atomic<i32>;
fn f(a: ptr<workgroup, atomic<i32>>) {
    atomicAdd(a, 1);
    atomicStore(&w, 2);
}
@compute @workgroup_size(1) fn cs() {
    f(&w);
}

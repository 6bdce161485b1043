// Dawn: takes it
// Umbrage: which a function cannot take
var<workgroup> w: atomic<i32>;
fn f(a: ptr<workgroup, atomic<i32>>) -> i32 {
    return atomicLoad(a) + atomicLoad(&w);
}
@compute @workgroup_size(1) fn cs() {
    let r = f(&w);
}

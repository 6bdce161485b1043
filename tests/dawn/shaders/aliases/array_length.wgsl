// Dawn: takes it
// Umbrage: which a function cannot take
@group(0) @binding(0) var<storage, read_write> s: array<i32>;
fn f(a: ptr<storage, array<i32>, read_write>) -> u32 {
    s[0] = 1;
    return arrayLength(a);
}
@compute @workgroup_size(1) fn cs() {
    let r = f(&s);
}

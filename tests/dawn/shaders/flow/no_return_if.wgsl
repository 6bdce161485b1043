// Dawn: refuses it: missing return at end of function
// Umbrage: `f` may end without a value
fn f(a: i32) -> i32 {
    if a > 1 {
        return 1;
    }
}
@compute @workgroup_size(1) fn cs() {
    let r = f(1);
}

// Dawn: refuses it: missing return at end of function
// Umbrage: `f` may end without a value
fn f() -> i32 {
    loop {
        break;
    }
}
@compute @workgroup_size(1) fn cs() {
    let r = f();
}

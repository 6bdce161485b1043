// Dawn: refuses it: loop does not exit
// Umbrage: no exit
fn f() {
    loop {
    }
}
@compute @workgroup_size(1) fn cs() {
    f();
}

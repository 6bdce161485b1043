// Dawn: takes it
fn f() -> i32 {
    loop {
        return 1;
    }
}
@compute @workgroup_size(1) fn cs() {
    let r = f();
}

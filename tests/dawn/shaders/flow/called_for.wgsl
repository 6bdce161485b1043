// Dawn: takes it
fn f() -> i32 {
    for (var i = 0; ; i++) {
        if i > 4 {
            return i;
        }
    }
}
@compute @workgroup_size(1) fn cs() {
    let r = f();
}

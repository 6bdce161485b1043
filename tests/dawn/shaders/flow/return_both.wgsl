// Dawn: takes it
fn f(a: i32) -> i32 {
    if a > 1 {
        return 1;
    } else {
        return 2;
    }
}
@compute @workgroup_size(1) fn cs() {
    let r = f(1);
}

// Dawn: takes it
fn f(x: i32) -> i32 {
    loop {
        return 1;
        continuing {
            break if x > 3;
        }
    }
}
@compute @workgroup_size(1) fn cs() {
    let r = f(1);
}

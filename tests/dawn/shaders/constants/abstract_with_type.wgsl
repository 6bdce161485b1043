// Dawn: takes it
@compute @workgroup_size(1) fn cs() {
    let r: u32 = 2147483648;
}

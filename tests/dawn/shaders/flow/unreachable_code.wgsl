// Dawn: takes it
@compute @workgroup_size(1) fn cs() {
    return;
    let a = 1;
}

// Dawn: takes it
// Umbrage: ivision by zero
@compute @workgroup_size(1) fn cs() {
    let r = false && (1 / 0 == 0);
}

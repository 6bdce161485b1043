// Dawn: takes it
// Umbrage: ivision by zero
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    let z = 0u;
    let r = n / z;
}

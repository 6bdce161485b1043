// Dawn: takes it
// Umbrage: hift amount
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    let z = 32u;
    let r = n << z;
}

// Dawn: takes it
// Umbrage: as many bits as it has
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    let z = 32u;
    let r = n << z;
}

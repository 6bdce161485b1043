// Dawn: refuses it: shift left operation results in sign change
// Umbrage: << operation overflowed
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = 1i << 31u;
}

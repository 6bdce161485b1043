// Dawn: refuses it: shift left value must be less than the bit width of the lhs, which is 32
// Umbrage: a shift by 32
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = n << 32u;
}

// Dawn: refuses it: shift left value must be less than the bit width of the lhs, which is 32
// Umbrage: a shift
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    n <<= 40u;
}

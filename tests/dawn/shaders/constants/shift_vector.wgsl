// Dawn: refuses it: shift right value must be less than the bit width of the lhs, which is 32
// Umbrage: a shift
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = vec2u(n) >> vec2u(1u, 32u);
}

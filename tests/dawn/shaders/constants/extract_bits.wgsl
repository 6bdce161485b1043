// Dawn: refuses it: 'offset' + 'count' must be less than or equal to the bit width of 'e'
// Umbrage: `extractBits` of 5 bits from bit 30
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = extractBits(n, 30u, 5u);
}

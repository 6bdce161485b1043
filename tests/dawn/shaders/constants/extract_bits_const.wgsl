// Dawn: refuses it: 'offset' + 'count' must be less than or equal to the bit width of 'e'
// Umbrage: `extractBits` of 5 bits from bit 30 on
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = extractBits(7u, 30u, 5u);
}

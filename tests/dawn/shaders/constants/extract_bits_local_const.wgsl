// Dawn: refuses it: 'offset' + 'count' must be less than or equal to the bit width of 'e'
// Umbrage: extractBits
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    const offset = 30;
    let r = extractBits(n, offset, 5u);
}

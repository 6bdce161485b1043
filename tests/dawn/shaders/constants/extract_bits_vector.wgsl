// Dawn: refuses it: 'offset' + 'count' must be less than or equal to the bit width of 'e'
// Umbrage: extractBits
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = extractBits(vec2u(n), 20u, 20u);
}

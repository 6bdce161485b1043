// Dawn: refuses it: 'offset' + 'count' must be less than or equal to the bit width of 'e'
// Umbrage: extractBits
fn f(n: u32) -> u32 {
    return extractBits(n, 16u, 17u);
}
@compute @workgroup_size(1) fn cs() {
    let r = f(3u);
}

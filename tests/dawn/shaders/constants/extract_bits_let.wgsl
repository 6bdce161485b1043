// Dawn: takes it
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    let offset = 30u;
    let r = extractBits(n, offset, 5u);
}

// Dawn: refuses it: An error occurred while running Null writer
// Umbrage: extractBits
override o: u32 = 30u;
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = extractBits(n, o, 5u);
}

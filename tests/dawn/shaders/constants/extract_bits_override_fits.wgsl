// Dawn: takes it
override o: u32 = 27u;
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = extractBits(n, o, 5u);
}

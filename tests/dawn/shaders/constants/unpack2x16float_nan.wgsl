// Dawn: refuses it: value nan cannot be represented as 'f32'
// Umbrage: unpack2x16float
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = unpack2x16float(0x7c01u);
}

// Dawn: refuses it: value inf cannot be represented as 'f32'
// Umbrage: bitcast
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = bitcast<f32>(0x7f800000u);
}

// Dawn: refuses it: value -inf cannot be represented as 'f32'
// Umbrage: bitcast
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = bitcast<vec2f>(vec2u(0u, 0xff800000u));
}

// Dawn: refuses it: value 850705917302346158658436518579420528640.0 cannot be represented as 'f32'
// Umbrage: `ldexp` of constants is inf, which no constant may be
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = ldexp(2.5, 128);
}

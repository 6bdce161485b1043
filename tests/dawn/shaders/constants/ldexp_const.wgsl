// Dawn: refuses it: value 510423550381407695195061911147652317184.0 cannot be represented as 'f32'
// Umbrage: `ldexp` of constants is inf, which no constant may be
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = ldexp(1.5, 128);
}

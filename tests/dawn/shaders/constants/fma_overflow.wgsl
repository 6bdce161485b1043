// Dawn: refuses it: '300000000549775575777803994281145270272.0 * 4.0' cannot be represented as 'f32'
// Umbrage: float literal is infinite
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = fma(3e38f, 4.0, 4.0);
}

// Dawn: refuses it: '300000000549775575777803994281145270272.0 * 300000000549775575777803994281145270272.0' cannot be represented as 'f32'
// Umbrage: length operation overflowed
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = length(vec2f(3e38f));
}

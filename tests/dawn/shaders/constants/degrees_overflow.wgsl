// Dawn: refuses it: '300000000549775575777803994281145270272.0 * 57.2957763671875' cannot be represented as 'f32'
// Umbrage: degrees operation overflowed
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = degrees(3e38f);
}

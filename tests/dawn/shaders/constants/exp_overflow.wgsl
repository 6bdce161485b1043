// Dawn: refuses it: e^100.0 cannot be represented as 'f32'
// Umbrage: exp operation overflowed
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = exp(100.0f);
}

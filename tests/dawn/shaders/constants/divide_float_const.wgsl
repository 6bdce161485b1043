// Dawn: refuses it: '1.0 / 0.0' cannot be represented as 'abstract-float'
// Umbrage: divide operation overflowed
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = 1.0 / 0.0;
}

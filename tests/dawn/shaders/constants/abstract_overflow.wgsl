// Dawn: refuses it: '9223372036854775807 + 1' cannot be represented as 'abstract-int'
// Umbrage: addition operation overflowed
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = 9223372036854775807 + 1;
}

// Dawn: refuses it: value 274877906816 cannot be represented as 'i32'
// Umbrage: no `i32`
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = 2147483647 * 128;
}

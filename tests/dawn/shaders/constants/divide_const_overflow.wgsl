// Dawn: refuses it: '-2147483648 / -1' cannot be represented as 'i32'
// Umbrage: division operation overflowed
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = (-2147483647i - 1i) / -1i;
}

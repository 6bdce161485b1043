// Dawn: refuses it: value 2147483649 cannot be represented as 'i32'
// Umbrage: no `i32`
@compute @workgroup_size(1) fn cs() {
    var r = 1 + 2147483647 + 1;
}

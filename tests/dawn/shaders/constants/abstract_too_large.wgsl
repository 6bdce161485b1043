// Dawn: refuses it: value 2147483648 cannot be represented as 'i32'
// Umbrage: the concrete type `i32` cannot represent the abstract value `2147483648` accurately
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = i32(2147483648);
}

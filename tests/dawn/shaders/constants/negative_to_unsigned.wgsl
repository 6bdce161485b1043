// Dawn: refuses it: value -1 cannot be represented as 'u32'
// Umbrage: the concrete type `u32` cannot represent the abstract value `-1` accurately
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = u32(-1);
}

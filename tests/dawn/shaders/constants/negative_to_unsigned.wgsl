// Dawn: refuses it: value -1 cannot be represented as 'u32'
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = u32(-1);
}

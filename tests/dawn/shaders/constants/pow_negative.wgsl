// Dawn: refuses it: '-1.0 ^ 2.0' cannot be represented as 'abstract-float'
// Umbrage: pow built-in function argument is out of valid range
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = pow(-1.0, 2.0);
}

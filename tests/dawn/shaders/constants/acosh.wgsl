// Dawn: refuses it: acosh must be called with a value >= 1.0
// Umbrage: acosh built-in function argument is out of valid range
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = acosh(0.5);
}

// Dawn: refuses it: acos must be called with a value in the range [-1 .. 1] (inclusive)
// Umbrage: acos
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = acos(quantizeToF16(2.0f));
}

// Dawn: refuses it: acos must be called with a value in the range [-1 .. 1] (inclusive)
// Umbrage: acos built-in function argument is out of valid range
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = acos(1.5);
}

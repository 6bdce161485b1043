// Dawn: refuses it: atanh must be called with a value in the range (-1 .. 1) (exclusive)
// Umbrage: atanh built-in function argument is out of valid range
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = atanh(1.0);
}

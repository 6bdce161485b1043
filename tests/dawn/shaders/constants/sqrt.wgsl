// Dawn: refuses it: sqrt must be called with a value >= 0
// Umbrage: sqrt built-in function argument is out of valid range
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = sqrt(-1.0);
}

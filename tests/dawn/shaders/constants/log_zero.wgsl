// Dawn: refuses it: log must be called with a value > 0
// Umbrage: log built-in function argument is out of valid range
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = log(0.0);
}

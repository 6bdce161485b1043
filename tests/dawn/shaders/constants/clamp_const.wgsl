// Dawn: refuses it: clamp called with 'low' (3) greater than 'high' (2)
// Umbrage: value of `low` is greater than `high` for clamp built-in function
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = clamp(1, 3, 2);
}

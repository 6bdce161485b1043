// Dawn: refuses it: integer division by zero is invalid
// Umbrage: divided by a constant
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = n / 0u;
}

// Dawn: refuses it: integer division by zero is invalid
// Umbrage: division by zero
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = select(1, 2, false) / 0;
}

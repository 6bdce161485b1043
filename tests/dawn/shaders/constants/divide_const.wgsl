// Dawn: refuses it: integer division by zero is invalid
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = 1 / 0;
}

// Dawn: refuses it: integer division by zero is invalid
// Umbrage: divided
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = vec2u(n) / vec2u();
}

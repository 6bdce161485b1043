// Dawn: refuses it: index 2 out of bounds [0..1]
// Umbrage: index 2 is out of bounds for expression
@compute @workgroup_size(1) fn cs() {
    var m = mat2x2f();
    let r = m[2];
}

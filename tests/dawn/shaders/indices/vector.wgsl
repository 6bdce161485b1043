// Dawn: refuses it: index 3 out of bounds [0..2]
// Umbrage: index 3 is out of bounds for expression
@compute @workgroup_size(1) fn cs() {
    var v = vec3f();
    let r = v[3];
}

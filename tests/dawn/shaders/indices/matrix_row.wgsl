// Dawn: refuses it: index 3 out of bounds [0..2]
@compute @workgroup_size(1) fn cs() {
    var m = mat2x3f();
    let r = m[1][3];
}

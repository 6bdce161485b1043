// Dawn: refuses it: index -1 out of bounds [0..2]
// Umbrage: the index -1 is out of bounds: there are 3 elements
@compute @workgroup_size(1) fn cs() {
    var a = array<f32, 3>();
    let r = a[-1];
}

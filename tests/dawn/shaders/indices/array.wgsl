// Dawn: refuses it: index 3 out of bounds [0..2]
// Umbrage: index 3 is out of bounds
@compute @workgroup_size(1) fn cs() {
    var a = array<f32, 3>();
    let r = a[3];
}

// Dawn: refuses it: index 2 out of bounds [0..1]
// Umbrage: index 2 is out of bounds
@compute @workgroup_size(1) fn cs() {
    var a = array<array<f32, 2>, 3>();
    let r = a[2][2];
}

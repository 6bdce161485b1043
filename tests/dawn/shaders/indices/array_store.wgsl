// Dawn: refuses it: index 4 out of bounds [0..2]
// Umbrage: index 4 is out of bounds
@compute @workgroup_size(1) fn cs() {
    var a = array<f32, 3>();
    a[4] = 1.0;
}

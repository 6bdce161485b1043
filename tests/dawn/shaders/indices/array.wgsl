// Dawn: refuses it: index 3 out of bounds [0..2]
@compute @workgroup_size(1) fn cs() {
    var a = array<f32, 3>();
    let r = a[3];
}

// Dawn: takes it
@compute @workgroup_size(1) fn cs() {
    var a = array<f32, 3>();
    let r = a[2];
}

// Dawn: takes it
override o = 2;
@compute @workgroup_size(1) fn cs() {
    var a = array<f32, 3>();
    let r = a[o];
}

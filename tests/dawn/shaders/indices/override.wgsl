// Dawn: refuses it: An error occurred while running Null writer
// Umbrage: the index 3 is out of bounds
override o = 3;
@compute @workgroup_size(1) fn cs() {
    var a = array<f32, 3>();
    let r = a[o];
}

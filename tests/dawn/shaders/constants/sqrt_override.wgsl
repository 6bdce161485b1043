// Dawn: refuses it: An error occurred while running Null writer
// Umbrage: `sqrt` of -1.0
override o: f32 = -1.0;
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = sqrt(o);
}

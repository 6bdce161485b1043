// Dawn: refuses it: An error occurred while running Null writer
// Umbrage: log2
override o: f32 = 0.0;
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = log2(o);
}

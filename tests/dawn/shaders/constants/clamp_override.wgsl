// Dawn: refuses it: An error occurred while running Null writer
// Umbrage: clamp
override o = 3.0;
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = clamp(f, o, 2.0);
}

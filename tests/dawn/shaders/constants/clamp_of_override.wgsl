// Dawn: refuses it: An error occurred while running Null writer
// Umbrage: `acos` of 3.0
override o = 100.0;
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = acos(clamp(o, -1.0, 3.0));
}

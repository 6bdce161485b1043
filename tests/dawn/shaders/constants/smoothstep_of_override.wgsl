// Dawn: refuses it: An error occurred while running Null writer
// Umbrage: smoothstep
override o = 3e38;
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = smoothstep(o, 100.0, -3e38);
}

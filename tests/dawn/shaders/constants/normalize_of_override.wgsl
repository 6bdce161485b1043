// Dawn: refuses it: An error occurred while running Null writer
// Umbrage: normalize
override o = 3e38;
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = normalize(vec2f(1.0, o));
}

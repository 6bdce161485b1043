// Dawn: refuses it: smoothstep called with 'low' (3.0) equal to 'high' (3.0)
// Umbrage: smoothstep
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = smoothstep(3.0, 3.0, 1.0);
}

// Umbrage: smoothstep
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = smoothstep(3e38f, -3e38f, 1.0);
}

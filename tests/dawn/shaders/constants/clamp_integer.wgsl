// Dawn: refuses it: clamp called with 'low' (3) greater than 'high' (2)
// Umbrage: clamp
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = clamp(n, 3u, 2u);
}

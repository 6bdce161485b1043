// Dawn: refuses it: clamp called with 'low' (3.0) greater than 'high' (2.0)
// Umbrage: clamp
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = clamp(vec2f(f), vec2f(0.0, 3.0), vec2f(2.0));
}

// Dawn: refuses it: clamp called with 'low' (3.0) greater than 'high' (2.0)
// Umbrage: `clamp` from 3.0 to 2.0
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = clamp(f, 3.0, 2.0);
}

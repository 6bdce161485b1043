// Dawn: refuses it: e2 must be less than or equal to 128
// Umbrage: ldexp
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = ldexp(f, 129);
}

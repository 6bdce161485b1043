// Dawn: refuses it: inverseSqrt must be called with a value > 0
// Umbrage: failed to convert expression to a concrete type
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = inverseSqrt(-1.0);
}

// Dawn: refuses it: value -70000.0 cannot be represented as 'f16'
// Umbrage: quantizeToF16
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = quantizeToF16(vec2f(1.0, -70000.0));
}

// Dawn: refuses it: value 65505.0 cannot be represented as 'f16'
// Umbrage: `quantizeToF16` of 65505.0, which no `f16` can hold
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = quantizeToF16(65505.0);
}

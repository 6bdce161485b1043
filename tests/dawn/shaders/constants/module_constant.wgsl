// Dawn: refuses it: value 70000.0 cannot be represented as 'f16'
// Umbrage: quantizeToF16
const A = 70000.0;
@compute @workgroup_size(1) fn cs() {
    let r = quantizeToF16(A);
}

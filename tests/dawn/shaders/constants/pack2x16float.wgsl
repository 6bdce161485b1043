// Dawn: refuses it: value 70000.0 cannot be represented as 'f16'
// Umbrage: pack2x16float
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = pack2x16float(vec2f(0.0, 70000.0));
}

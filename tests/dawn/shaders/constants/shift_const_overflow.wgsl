// Dawn: refuses it: mixing '<<' and '<<' requires parenthesis
// Umbrage: unexpected `<<`, expected `;`
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = 1u << 31u << 1u;
}

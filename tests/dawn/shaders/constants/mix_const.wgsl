// Dawn: takes it
// Umbrage: naga does not evaluate
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = mix(1.0, 2.0, 0.5);
}

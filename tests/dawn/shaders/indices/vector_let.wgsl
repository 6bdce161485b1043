// Dawn: takes it
// Umbrage: out of bounds
@compute @workgroup_size(1) fn cs() {
    var v = vec3f();
    let i = 3;
    let r = v[i];
}

// Dawn: refuses it: zero length vector can not be normalized
// Umbrage: normalize built-in function argument is out of valid range
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = normalize(vec3f());
}

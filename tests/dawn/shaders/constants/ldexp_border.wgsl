// Dawn: takes it
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = ldexp(f, 128);
}

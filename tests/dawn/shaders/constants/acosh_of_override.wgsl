// Dawn: takes it
override o = 3e38;
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = acosh(o);
}

// Dawn: takes it
override o = 0u;
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    let z = o;
    let r = n % z;
}

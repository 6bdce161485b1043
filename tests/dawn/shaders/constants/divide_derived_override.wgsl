// Dawn: refuses it: An error occurred while running Null writer
// Umbrage: divided
override o = 2u;
override p = o - 2u;
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = n / p;
}

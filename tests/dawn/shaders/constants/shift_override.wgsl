// Dawn: refuses it: An error occurred while running Null writer
// Umbrage: a shift
override o: u32 = 32u;
@compute @workgroup_size(1) fn cs() {
    var n = 5u;
    var f = 1.5f;
    let r = n << o;
}

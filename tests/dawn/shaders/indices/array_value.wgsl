// Dawn: refuses it: index 3 out of bounds [0..2]
// Umbrage: cannot access at the index
@compute @workgroup_size(1) fn cs() {
    let r = array(1, 2, 3)[3];
}

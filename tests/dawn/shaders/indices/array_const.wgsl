// Dawn: refuses it: index 3 out of bounds [0..2]
// Umbrage: cannot access at the index
const A = array(1, 2, 3);
@compute @workgroup_size(1) fn cs() {
    let r = A[3];
}

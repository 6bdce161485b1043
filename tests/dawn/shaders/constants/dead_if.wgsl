// Dawn: refuses it: integer division by zero is invalid
// Umbrage: division by zero
@compute @workgroup_size(1) fn cs() {
    if false {
        let r = 1 / 0;
    }
}

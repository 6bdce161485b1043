// Dawn: refuses it: loop does not exit
// Umbrage: the loop has no exit
@compute @workgroup_size(1) fn cs() {
    loop {
        continue;
        break;
    }
}

// Dawn: refuses it: for-loop does not exit
// Umbrage: no exit
@compute @workgroup_size(1) fn cs() {
    for (var i = 0; ; i++) {
        if i > 3 {
            continue;
        }
    }
}

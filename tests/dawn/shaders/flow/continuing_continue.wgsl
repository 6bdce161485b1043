// Dawn: refuses it: continuing blocks must not contain a continue statement
// Umbrage: the `continue` is used outside of a `loop` context
@compute @workgroup_size(1) fn cs() {
    var i = 0;
    loop {
        if i > 3 {
            break;
        }
        continuing {
            i += 1;
            if i > 2 {
                continue;
            }
        }
    }
}

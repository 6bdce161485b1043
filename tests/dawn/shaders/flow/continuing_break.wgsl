// Dawn: refuses it: 'break' must not be used to exit from a continuing block. Use 'break if' instead.
// Umbrage: expected if, found ";"
@compute @workgroup_size(1) fn cs() {
    loop {
        continuing {
            break;
        }
    }
}

// Dawn: refuses it: continuing blocks must not contain a return statement
// Umbrage: the `return` is called within a `continuing` block
@compute @workgroup_size(1) fn cs() {
    loop {
        continuing {
            return;
        }
    }
}

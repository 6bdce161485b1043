// Dawn: refuses it: continuing blocks must not contain a continue statement
@compute @workgroup_size(1) fn cs() {
    loop {
        continuing {
            continue;
        }
    }
}

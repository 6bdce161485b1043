// Dawn: refuses it: break statement must be in a loop or switch case
// Umbrage: the `break` is used outside of a `loop` or `switch` context
@compute @workgroup_size(1) fn cs() {
    break;
}

// Dawn: refuses it: break statement must be in a loop or switch case
@compute @workgroup_size(1) fn cs() {
    break;
}

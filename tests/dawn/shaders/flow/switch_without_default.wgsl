// Dawn: refuses it: switch statement must have a default clause
// Umbrage: the `switch` is missing a `default` case
@compute @workgroup_size(1) fn cs() {
    switch 1 {
        case 1: {
        }
    }
}

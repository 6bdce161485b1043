// Dawn: refuses it: duplicate switch case '1'
// Umbrage: multiple `switch` cases for 1 are present
@compute @workgroup_size(1) fn cs() {
    switch 1 {
        case 1: {
        }
        case 1: {
        }
        default: {
        }
    }
}

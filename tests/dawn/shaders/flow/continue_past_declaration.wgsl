// Dawn: refuses it: continue statement bypasses declaration of 'y'
// Umbrage: passes over the declaration of `y`
@compute @workgroup_size(1) fn cs() {
    var x = 1;
    loop {
        if x > 2 {
            continue;
        }
        var y = 2;
        continuing {
            x = y;
            break if x > 4;
        }
    }
}

// Dawn: takes it
@compute @workgroup_size(1) fn cs() {
    var x = 1;
    loop {
        var y = 2;
        if x > 2 {
            continue;
        }
        continuing {
            x = y;
            break if x > 4;
        }
    }
}

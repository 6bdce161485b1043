// Dawn: takes it
@compute @workgroup_size(1) fn cs() {
    var x = 1;
    loop {
        if x > 2 {
            continue;
        }
        var y = 2;
        x += y;
        continuing {
            break if x > 4;
        }
    }
}

// Dawn: takes it
@compute @workgroup_size(1) fn cs() {
    var i = 0;
    loop {
        if i > 3 {
            break;
        }
        i++;
    }
}

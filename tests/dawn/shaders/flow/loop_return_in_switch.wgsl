// Dawn: takes it
@compute @workgroup_size(1) fn cs() {
    loop {
        switch 1 {
            default: {
                return;
            }
        }
    }
}

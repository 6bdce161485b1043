// Dawn: takes it
override many: i32 = 1;
@compute @workgroup_size(64) fn cs() {
    if many > 0 {
        workgroupBarrier();
    }
}

// Dawn: takes it
struct Input {
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
}
@compute @workgroup_size(64) fn cs(given: Input) {
    if given.group.x > 0 {
        workgroupBarrier();
    }
}

// Dawn: takes it
@compute @workgroup_size(64) fn cs(@builtin(num_workgroups) given: vec3u) {
    if any(vec3u(given) > vec3u(0)) {
        workgroupBarrier();
    }
}

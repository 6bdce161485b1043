// Dawn: refuses it: 'workgroupBarrier' must only be called from uniform control flow
// Umbrage: must only be called from uniform control flow
struct Input {
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_id) local: vec3u,
}
@compute @workgroup_size(64) fn cs(given: Input) {
    if given.group.x > 0 {
        workgroupBarrier();
    }
}

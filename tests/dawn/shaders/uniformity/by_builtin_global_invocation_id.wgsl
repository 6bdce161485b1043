// Dawn: refuses it: 'workgroupBarrier' must only be called from uniform control flow
// Umbrage: must only be called from uniform control flow
@compute @workgroup_size(64) fn cs(@builtin(global_invocation_id) given: vec3u) {
    if any(vec3u(given) > vec3u(0)) {
        workgroupBarrier();
    }
}

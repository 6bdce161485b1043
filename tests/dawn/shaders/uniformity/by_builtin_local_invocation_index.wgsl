// Dawn: refuses it: 'workgroupBarrier' must only be called from uniform control flow
// Umbrage: must only be called from uniform control flow
@compute @workgroup_size(64) fn cs(@builtin(local_invocation_index) given: u32) {
    if any(u32(given) > u32(0)) {
        workgroupBarrier();
    }
}

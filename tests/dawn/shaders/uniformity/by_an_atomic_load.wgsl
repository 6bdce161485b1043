// Dawn: refuses it: 'workgroupBarrier' must only be called from uniform control flow
// Umbrage: must only be called from uniform control flow
var<workgroup> count: atomic<i32>;
@compute @workgroup_size(64) fn cs() {
    if atomicLoad(&count) > 0 {
        workgroupBarrier();
    }
}

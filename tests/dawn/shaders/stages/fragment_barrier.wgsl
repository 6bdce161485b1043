// Dawn: refuses it: built-in cannot be used by fragment pipeline stage
// Umbrage: uses operations forbidden at this stage
@fragment fn fs() {
    workgroupBarrier();
}

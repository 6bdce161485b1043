// Dawn: refuses it: built-in cannot be used by fragment pipeline stage
@fragment fn fs() {
    workgroupBarrier();
}

// Dawn: refuses it: var with 'workgroup' address space cannot be used by fragment pipeline stage
// Umbrage: workgroup variable
var<workgroup> w: f32;
@fragment fn fs() {
    w = 1.0;
}

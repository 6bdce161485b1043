// Dawn: refuses it: var with 'workgroup' address space cannot be used by fragment pipeline stage
var<workgroup> w: f32;
@fragment fn fs() {
    w = 1.0;
}

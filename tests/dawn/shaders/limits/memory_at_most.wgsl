// Dawn: takes it
var<workgroup> w: array<f32, 4096>;
@compute @workgroup_size(1) fn cs() {
    w[0] = 1.0;
}

// Dawn: takes it
override n = 64;
var<workgroup> w: array<f32, n>;
@compute @workgroup_size(1) fn cs() {
    w[0] = 1.0;
}

// Dawn: takes it
var<workgroup> w: array<f32, 4092>;
var<workgroup> v: f32;
@compute @workgroup_size(1) fn cs() {
    w[0] = v;
}

// Dawn: takes it
var<workgroup> w: array<bool, 4096>;
@compute @workgroup_size(1) fn cs() {
    w[0] = true;
}

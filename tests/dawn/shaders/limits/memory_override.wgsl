// Dawn: refuses it: The total use of workgroup storage (20000 bytes) is larger than the maximum allowed (16384 bytes).
// Umbrage: maxComputeWorkgroupStorageSize
override n = 5000;
var<workgroup> w: array<f32, n>;
@compute @workgroup_size(1) fn cs() {
    w[0] = 1.0;
}

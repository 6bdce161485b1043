// Dawn: refuses it: The total use of workgroup storage (16416 bytes) is larger than the maximum allowed (16384 bytes).
// Umbrage: maxComputeWorkgroupStorageSize
var<workgroup> w: array<mat3x3f, 342>;
@compute @workgroup_size(1) fn cs() {
    w[0] = mat3x3f();
}

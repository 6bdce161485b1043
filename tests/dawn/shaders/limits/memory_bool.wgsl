// Dawn: refuses it: The total use of workgroup storage (16400 bytes) is larger than the maximum allowed (16384 bytes).
// Umbrage: maxComputeWorkgroupStorageSize
var<workgroup> w: array<bool, 4097>;
@compute @workgroup_size(1) fn cs() {
    w[0] = true;
}

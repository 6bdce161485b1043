// Dawn: refuses it: The total use of workgroup storage (16400 bytes) is larger than the maximum allowed (16384 bytes).
// Umbrage: maxComputeWorkgroupStorageSize
var<workgroup> w: array<atomic<u32>, 4097>;
@compute @workgroup_size(1) fn cs() {
    atomicStore(&w[0], 1u);
}

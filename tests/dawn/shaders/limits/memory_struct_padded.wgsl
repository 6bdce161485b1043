// Dawn: refuses it: The total use of workgroup storage (16416 bytes) is larger than the maximum allowed (16384 bytes).
// Umbrage: maxComputeWorkgroupStorageSize
struct S { @size(32) a: f32 }
var<workgroup> w: array<S, 513>;
@compute @workgroup_size(1) fn cs() {
    w[0].a = 1.0;
}

// Dawn: refuses it: The total use of workgroup storage (16400 bytes) is larger than the maximum allowed (16384 bytes).
// Umbrage: maxComputeWorkgroupStorageSize
struct S { a: bool, b: f32 }
var<workgroup> w: array<S, 2049>;
@compute @workgroup_size(1) fn cs() {
    w[0].a = true;
}

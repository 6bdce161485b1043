// Dawn: refuses it: Entry-point uses workgroup_size(512, 1, 1) that exceeds the maximum allowed (256, 256, 64).
// Umbrage: maxComputeWorkgroupSizeX
override n = 512;
@compute @workgroup_size(n) fn cs() {}

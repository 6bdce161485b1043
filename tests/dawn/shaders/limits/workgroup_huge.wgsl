// Dawn: refuses it: Entry-point uses workgroup_size(100000, 1, 1) that exceeds the maximum allowed (256, 256, 64).
// Umbrage: maxComputeWorkgroupSizeX
@compute @workgroup_size(100000) fn cs() {}

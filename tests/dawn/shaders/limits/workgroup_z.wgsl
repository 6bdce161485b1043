// Dawn: refuses it: Entry-point uses workgroup_size(1, 1, 65) that exceeds the maximum allowed (256, 256, 64).
// Umbrage: maxComputeWorkgroupSizeZ
@compute @workgroup_size(1, 1, 65) fn cs() {}

// Dawn: refuses it: Entry-point uses workgroup_size(1, 257, 1) that exceeds the maximum allowed (256, 256, 64).
// Umbrage: maxComputeWorkgroupSizeY
@compute @workgroup_size(1, 257) fn cs() {}

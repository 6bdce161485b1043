// Dawn: refuses it: The total number of workgroup invocations (1024) exceeds the maximum allowed (256).
// Umbrage: maxComputeInvocationsPerWorkgroup
@compute @workgroup_size(32, 32) fn cs() {}

// Dawn: refuses it: The total number of workgroup invocations (2048) exceeds the maximum allowed (256).
// Umbrage: maxComputeInvocationsPerWorkgroup
override n = 64;
@compute @workgroup_size(n, n / 2) fn cs() {}

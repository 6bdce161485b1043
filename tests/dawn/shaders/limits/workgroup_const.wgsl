// Dawn: refuses it: The total number of workgroup invocations (2048) exceeds the maximum allowed (256).
// Umbrage: maxComputeInvocationsPerWorkgroup
const N = 32;
@compute @workgroup_size(N, N * 2) fn cs() {}

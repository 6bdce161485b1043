// Dawn: refuses it: '@builtin(local_invocation_id)' appears multiple times as pipeline input
// Umbrage: `@builtin(local_invocation_id)` stands twice
@compute @workgroup_size(1) fn cs(@builtin(local_invocation_id) a: vec3u, @builtin(local_invocation_id) b: vec3u) {}

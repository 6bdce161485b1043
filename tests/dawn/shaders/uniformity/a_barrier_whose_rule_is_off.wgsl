// Dawn: refuses it: 'workgroupBarrier' must only be called from uniform control flow
// Umbrage: must only be called from uniform control flow
diagnostic(off, derivative_uniformity);
@group(0) @binding(0) var<storage, read_write> shared_values: array<i32>;
@group(0) @binding(1) var<storage> same_values: array<i32>;
@group(0) @binding(2) var<uniform> same: vec4i;
var<private> own: i32;
var<workgroup> room: array<i32, 4>;
@compute @workgroup_size(64) fn cs(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u) {
    if own > 0 {
        workgroupBarrier();
    }
}

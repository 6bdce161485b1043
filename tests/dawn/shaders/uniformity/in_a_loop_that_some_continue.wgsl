// Dawn: refuses it: 'workgroupBarrier' must only be called from uniform control flow
// Umbrage: must only be called from uniform control flow
@group(0) @binding(0) var<storage, read_write> shared_values: array<i32>;
@group(0) @binding(1) var<storage> same_values: array<i32>;
@group(0) @binding(2) var<uniform> same: vec4i;
var<private> own: i32;
var<workgroup> room: array<i32, 4>;
@compute @workgroup_size(64) fn cs(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u) {
    for (var i = 0u; i < group.x; i++) {
        if local.x > i {
            continue;
        }
        workgroupBarrier();
    }
}

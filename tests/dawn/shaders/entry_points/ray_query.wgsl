// Dawn: refuses it: expected extension
// Umbrage: this needs ray queries, which the target `webgpu` does not offer
enable wgpu_ray_query;
@group(0) @binding(0) var t: acceleration_structure;
@fragment fn fs() {
    var q: ray_query;
}

// Dawn: refuses it: expected extension
enable wgpu_ray_query;
@group(0) @binding(0) var t: acceleration_structure;
@fragment fn fs() {
    var q: ray_query;
}

// Dawn: takes it
@group(0) @binding(0) var s: texture_storage_2d<rgba8sint, read>;
@compute @workgroup_size(1) fn cs() {
    let r = textureLoad(s, vec2i());
}

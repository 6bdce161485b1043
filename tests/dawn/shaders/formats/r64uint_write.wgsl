// Dawn: refuses it: unresolved texel format 'r64uint'
// Umbrage: u64
@group(0) @binding(0) var s: texture_storage_2d<r64uint, write>;
@compute @workgroup_size(1) fn cs() {
    textureStore(s, vec2i(), vec4u());
}

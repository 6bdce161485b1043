// Dawn: takes it
@group(0) @binding(0) var s: texture_storage_2d<r32float, write>;
@compute @workgroup_size(1) fn cs() {
    textureStore(s, vec2i(), vec4f());
}

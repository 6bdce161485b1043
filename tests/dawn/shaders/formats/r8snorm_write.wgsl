// Dawn: refuses it: Texture format TextureFormat::R8Snorm does not support storage texture access StorageTextureAccess::WriteOnly.
// Umbrage: a storage texture cannot have the format `r8snorm` without a feature of the device
@group(0) @binding(0) var s: texture_storage_2d<r8snorm, write>;
@compute @workgroup_size(1) fn cs() {
    textureStore(s, vec2i(), vec4f());
}

// Dawn: refuses it: Texture format TextureFormat::R16Float does not support storage texture access StorageTextureAccess::WriteOnly.
// Umbrage: a storage texture cannot have the format `r16float` without a feature of the device
@group(0) @binding(0) var s: texture_storage_2d<r16float, write>;
@compute @workgroup_size(1) fn cs() {
    textureStore(s, vec2i(), vec4f());
}

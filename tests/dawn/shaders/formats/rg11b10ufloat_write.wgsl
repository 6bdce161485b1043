// Dawn: refuses it: Texture format TextureFormat::RG11B10Ufloat does not support storage texture access StorageTextureAccess::WriteOnly.
// Umbrage: a storage texture cannot have the format `rg11b10ufloat` without a feature of the device
@group(0) @binding(0) var s: texture_storage_2d<rg11b10ufloat, write>;
@compute @workgroup_size(1) fn cs() {
    textureStore(s, vec2i(), vec4f());
}

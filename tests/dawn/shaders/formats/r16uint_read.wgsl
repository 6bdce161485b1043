// Dawn: refuses it: Texture format TextureFormat::R16Uint does not support storage texture access StorageTextureAccess::ReadOnly.
// Umbrage: a storage texture cannot have the format `r16uint` without a feature of the device
@group(0) @binding(0) var s: texture_storage_2d<r16uint, read>;
@compute @workgroup_size(1) fn cs() {
    let r = textureLoad(s, vec2i());
}

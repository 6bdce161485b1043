// Dawn: refuses it: Texture format TextureFormat::R8Uint does not support storage texture access StorageTextureAccess::ReadOnly.
// Umbrage: a storage texture cannot have the format `r8uint` without a feature of the device
@group(0) @binding(0) var s: texture_storage_2d<r8uint, read>;
@compute @workgroup_size(1) fn cs() {
    let r = textureLoad(s, vec2i());
}

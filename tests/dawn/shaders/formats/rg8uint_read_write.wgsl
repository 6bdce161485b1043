// Dawn: refuses it: Texture format TextureFormat::RG8Uint does not support storage texture access StorageTextureAccess::ReadWrite.
// Umbrage: a storage texture cannot have the format `rg8uint` without a feature of the device
@group(0) @binding(0) var s: texture_storage_2d<rg8uint, read_write>;
@compute @workgroup_size(1) fn cs() {
    let r = textureLoad(s, vec2i());
}

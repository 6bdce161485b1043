// Dawn: refuses it: Texture format TextureFormat::RGBA8Uint does not support storage texture access StorageTextureAccess::ReadWrite.
// Umbrage: a storage texture of the format `rgba8uint` cannot be read and written at once
@group(0) @binding(0) var s: texture_storage_2d<rgba8uint, read_write>;
@compute @workgroup_size(1) fn cs() {
    let r = textureLoad(s, vec2i());
}

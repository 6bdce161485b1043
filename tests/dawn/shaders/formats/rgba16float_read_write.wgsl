// Dawn: refuses it: Texture format TextureFormat::RGBA16Float does not support storage texture access StorageTextureAccess::ReadWrite.
// Umbrage: a storage texture of the format `rgba16float` cannot be read and written at once
@group(0) @binding(0) var s: texture_storage_2d<rgba16float, read_write>;
@compute @workgroup_size(1) fn cs() {
    let r = textureLoad(s, vec2i());
}

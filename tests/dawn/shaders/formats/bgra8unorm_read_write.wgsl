// Dawn: refuses it: Texture format TextureFormat::BGRA8Unorm does not support storage texture access StorageTextureAccess::ReadWrite.
// Umbrage: a storage texture cannot have the format `bgra8unorm` without a feature of the device
@group(0) @binding(0) var s: texture_storage_2d<bgra8unorm, read_write>;
@compute @workgroup_size(1) fn cs() {
    let r = textureLoad(s, vec2i());
}

// Dawn: refuses it: Unsupported texture format TextureFormat::R16Unorm, reason: requires feature FeatureName::TextureFormatsTier1.
// Umbrage: this needs storage textures of 16-bit normalized formats, which the target `webgpu` does not offer
@group(0) @binding(0) var s: texture_storage_2d<r16unorm, write>;
@compute @workgroup_size(1) fn cs() {
    textureStore(s, vec2i(), vec4f());
}

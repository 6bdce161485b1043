// Dawn: refuses it: unresolved texel format 'r64uint'
// Umbrage: a storage texture cannot have the format `r64uint` without a feature of the device
@group(0) @binding(0) var s: texture_storage_2d<r64uint, read_write>;
@compute @workgroup_size(1) fn cs() {
    let r = textureLoad(s, vec2i());
}

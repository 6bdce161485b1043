// Dawn: refuses it: 'workgroupBarrier' must only be called from uniform control flow
// Umbrage: must only be called from uniform control flow
@group(0) @binding(0) var image: texture_storage_2d<r32float, read_write>;
@compute @workgroup_size(64) fn cs() {
    if textureLoad(image, vec2i()).x > 0 {
        workgroupBarrier();
    }
}

// Dawn: takes it
@group(0) @binding(0) var image: texture_storage_2d<r32float, read>;
@compute @workgroup_size(64) fn cs() {
    if textureLoad(image, vec2i()).x > 0 {
        workgroupBarrier();
    }
}

// Dawn: refuses it: extension 'dual_source_blending' is not allowed in the current environment
// Umbrage: this needs blending of two sources (`@blend_src`), which the target `webgpu` does not offer
enable dual_source_blending;
struct O {
    @location(0) @blend_src(0) a: vec4f,
    @location(0) @blend_src(1) b: vec4f,
}
@fragment fn fs() -> O {
    var o: O;
    return o;
}

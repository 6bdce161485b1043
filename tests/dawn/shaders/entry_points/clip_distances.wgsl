// Dawn: refuses it: extension 'clip_distances' is not allowed in the current environment
// Umbrage: this needs `@builtin(clip_distances)`, which the target `webgpu` does not offer
enable clip_distances;
struct G {
    @builtin(position) p: vec4f,
    @builtin(clip_distances) c: array<f32, 4>,
}
@vertex fn vs() -> G {
    var g: G;
    return g;
}

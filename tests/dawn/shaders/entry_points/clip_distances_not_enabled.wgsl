// Dawn: refuses it: use of '@builtin(clip_distances)' requires enabling extension 'clip_distances'
// Umbrage: the `clip_distances` enable extension is not enabled
struct G {
    @builtin(position) p: vec4f,
    @builtin(clip_distances) c: array<f32, 4>,
}
@vertex fn vs() -> G {
    var g: G;
    return g;
}

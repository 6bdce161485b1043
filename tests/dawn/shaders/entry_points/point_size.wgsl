// Dawn: refuses it: expected builtin value name
// Umbrage: the built-in value `point_size` is none of WGSL's, and what some devices offer beyond it modules cannot ask for
struct G {
    @builtin(position) p: vec4f,
    @builtin(point_size) s: f32,
}
@vertex fn vs() -> G {
    var g: G;
    return g;
}

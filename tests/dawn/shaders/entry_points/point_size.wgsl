// Dawn: refuses it: expected builtin value name
struct G {
    @builtin(position) p: vec4f,
    @builtin(point_size) s: f32,
}
@vertex fn vs() -> G {
    var g: G;
    return g;
}

// Dawn: refuses it: [EntryPoint "vs"] infringes limits:
// Umbrage: maxVertexAttributes
@vertex fn vs(
    @builtin(vertex_index) vertex: u32,
    @builtin(instance_index) instance: u32,
    @location(0) x0: f32,
    @location(1) x1: f32,
    @location(2) x2: f32,
    @location(3) x3: f32,
    @location(4) x4: f32,
    @location(5) x5: f32,
    @location(6) x6: f32,
    @location(7) x7: f32,
    @location(8) x8: f32,
    @location(9) x9: f32,
    @location(10) x10: f32,
    @location(11) x11: f32,
    @location(12) x12: f32,
    @location(13) x13: f32,
    @location(14) x14: f32,
    @location(15) x15: f32,
    @location(16) x16: f32,
) -> @builtin(position) vec4f {
    return vec4f(x0);
}

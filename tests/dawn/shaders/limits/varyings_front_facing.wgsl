// Dawn: refuses it: [EntryPoint "fs"] infringes limits:
// Umbrage: maxInterStageShaderVariables
struct Given {
    @location(0) a0: f32,
    @location(1) a1: f32,
    @location(2) a2: f32,
    @location(3) a3: f32,
    @location(4) a4: f32,
    @location(5) a5: f32,
    @location(6) a6: f32,
    @location(7) a7: f32,
    @location(8) a8: f32,
    @location(9) a9: f32,
    @location(10) a10: f32,
    @location(11) a11: f32,
    @location(12) a12: f32,
    @location(13) a13: f32,
    @location(14) a14: f32,
    @location(15) a15: f32,
    @builtin(position) position: vec4f,
}
struct Taken {
    @location(0) a0: f32,
    @location(1) a1: f32,
    @location(2) a2: f32,
    @location(3) a3: f32,
    @location(4) a4: f32,
    @location(5) a5: f32,
    @location(6) a6: f32,
    @location(7) a7: f32,
    @location(8) a8: f32,
    @location(9) a9: f32,
    @location(10) a10: f32,
    @location(11) a11: f32,
    @location(12) a12: f32,
    @location(13) a13: f32,
    @location(14) a14: f32,
    @location(15) a15: f32,
    @builtin(front_facing) front: bool,
}
@vertex fn vs() -> Given {
    var given: Given;
    return given;
}
@fragment fn fs(taken: Taken) -> @location(0) vec4f {
    return vec4f();
}

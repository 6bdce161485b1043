// Dawn: refuses it: [EntryPoint "vs"] infringes limits:
// Umbrage: maxInterStageShaderVariables
struct Given {
    @location(16) a0: f32,
    @builtin(position) position: vec4f,
}
struct Taken {
    @location(16) a0: f32,
}
@vertex fn vs() -> Given {
    var given: Given;
    return given;
}
@fragment fn fs(taken: Taken) -> @location(0) vec4f {
    return vec4f();
}

// Dawn: refuses it: [EntryPoint "fs"] infringes limits:
// Umbrage: maxBindingsPerBindGroup
@group(0) @binding(65535) var t: texture_2d<f32>;
@fragment fn fs() -> @location(0) vec4f {
    return textureLoad(t, vec2i(), 0);
}

// Dawn: refuses it: [EntryPoint "fs"] infringes limits:
// Umbrage: maxBindingsPerBindGroup
@group(0) @binding(1000) var<uniform> u: vec4f;
@fragment fn fs() -> @location(0) vec4f {
    return u;
}

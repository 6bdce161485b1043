// Dawn: refuses it: [EntryPoint "fs"] infringes limits:
// Umbrage: maxBindGroups
@group(4) @binding(0) var<uniform> u: vec4f;
@fragment fn fs() -> @location(0) vec4f {
    return u;
}

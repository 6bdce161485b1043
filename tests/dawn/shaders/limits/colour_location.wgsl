// Dawn: refuses it: [EntryPoint "fs"] infringes limits:
// Umbrage: maxColorAttachments
@fragment fn fs() -> @location(8) vec4f {
    return vec4f();
}

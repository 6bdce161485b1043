// Dawn: refuses it: [EntryPoint "fs"] infringes limits:
// Umbrage: maxColorAttachments
struct Colours {
    @location(0) c0: vec4f,
    @location(1) c1: vec4f,
    @location(2) c2: vec4f,
    @location(3) c3: vec4f,
    @location(4) c4: vec4f,
    @location(5) c5: vec4f,
    @location(6) c6: vec4f,
    @location(7) c7: vec4f,
    @location(8) c8: vec4f,
}
@fragment fn fs() -> Colours {
    var colours: Colours;
    return colours;
}

// Dawn: refuses it: [EntryPoint "vs"] infringes limits:
// Umbrage: maxVertexAttributes
@vertex fn vs(@location(16) x: f32) -> @builtin(position) vec4f {
    return vec4f(x);
}

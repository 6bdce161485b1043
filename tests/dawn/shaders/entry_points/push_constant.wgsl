// Dawn: refuses it: unresolved address space 'push_constant'
// Umbrage: the address space `push_constant` is none of WGSL's, and what some devices offer beyond it modules cannot ask for
var<push_constant> p: vec4f;
@fragment fn fs() -> @location(0) vec4f {
    return p;
}

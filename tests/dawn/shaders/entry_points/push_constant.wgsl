// Dawn: refuses it: unresolved address space 'push_constant'
var<push_constant> p: vec4f;
@fragment fn fs() -> @location(0) vec4f {
    return p;
}

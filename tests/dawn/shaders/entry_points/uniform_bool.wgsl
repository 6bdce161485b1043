// Dawn: refuses it: type 'bool' cannot be used in address space 'uniform' as it is non-host-shareable
// Umbrage: the type will not do here: it is not what a host can share, as numbers are and `bool` is not
@group(0) @binding(0) var<uniform> u: bool;
@fragment fn fs() -> @location(0) vec4f {
    return select(vec4f(), vec4f(1), u);
}

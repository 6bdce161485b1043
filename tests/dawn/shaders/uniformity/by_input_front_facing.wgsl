// Dawn: refuses it: 'dpdx' must only be called from uniform control flow
// Umbrage: must only be called from uniform control flow
@fragment fn fs(@builtin(front_facing) at: bool) -> @location(0) vec4f {
    if at {
        return vec4f(dpdx(1.0));
    }
    return vec4f();
}

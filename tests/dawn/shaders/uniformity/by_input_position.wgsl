// Dawn: refuses it: 'dpdx' must only be called from uniform control flow
// Umbrage: must only be called from uniform control flow
@fragment fn fs(@builtin(position) at: vec4f) -> @location(0) vec4f {
    if at.x > 0 {
        return vec4f(dpdx(1.0));
    }
    return vec4f();
}

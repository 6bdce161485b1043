// Dawn: refuses it: 'dpdx' must only be called from uniform control flow
// Umbrage: must only be called from uniform control flow
@fragment fn fs(@location(0) @interpolate(flat) at: i32) -> @location(0) vec4f {
    if at > 0 {
        return vec4f(dpdx(1.0));
    }
    return vec4f();
}

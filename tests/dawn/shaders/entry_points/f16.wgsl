// Dawn: refuses it: extension 'f16' is not allowed in the current environment
// Umbrage: this needs half-precision floats (`f16`), which the target `webgpu` does not offer
enable f16;
@fragment fn fs() -> @location(0) vec4f {
    let a = 1.0h;
    return vec4f(f32(a));
}

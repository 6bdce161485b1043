// Dawn: refuses it: use of 'binding_array' requires the 'sized_binding_array'language feature, which is not allowed in the current environment
// Umbrage: the type `binding_array` is none of WGSL's, and what some devices offer beyond it modules cannot ask for
@group(0) @binding(0) var t: binding_array<texture_2d<f32>, 4>;
@fragment fn fs() -> @location(0) vec4f {
    return textureLoad(t[0], vec2i(), 0);
}

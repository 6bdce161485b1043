// Dawn: takes it
@group(0) @binding(0) var t: texture_cube_array<f32>;
@group(0) @binding(1) var s: sampler;
@fragment fn fs() -> @location(0) vec4f {
    return textureSample(t, s, vec3f(), 0);
}

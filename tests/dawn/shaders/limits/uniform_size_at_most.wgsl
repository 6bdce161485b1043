// Dawn: takes it
@group(0) @binding(0) var<uniform> u: array<vec4f, 4096>;
@fragment fn fs() -> @location(0) vec4f {
    return u[0];
}

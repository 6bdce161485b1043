// Dawn: takes it
@group(0) @binding(0) var<storage> u: array<vec4f, 8388608>;
@fragment fn fs() -> @location(0) vec4f {
    return u[0];
}

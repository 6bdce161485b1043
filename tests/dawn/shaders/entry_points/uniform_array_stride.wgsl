// Dawn: takes it
// Umbrage: stride
@group(0) @binding(0) var<uniform> u: array<f32, 4>;
@fragment fn fs() -> @location(0) vec4f {
    return vec4f(u[0]);
}

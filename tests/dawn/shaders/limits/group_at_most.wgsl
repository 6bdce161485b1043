// Dawn: takes it
@group(3) @binding(0) var<uniform> u: vec4f;
@fragment fn fs() -> @location(0) vec4f {
    return u;
}

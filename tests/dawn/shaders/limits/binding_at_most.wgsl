// Dawn: takes it
@group(0) @binding(999) var<uniform> u: vec4f;
@fragment fn fs() -> @location(0) vec4f {
    return u;
}

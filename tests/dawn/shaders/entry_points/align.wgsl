// Dawn: takes it
struct Inner { z: f32, @align(32) x: f32 }
@group(0) @binding(0) var<storage> given: Inner;
@fragment fn fs() -> @location(0) vec4f {
    return vec4f(given.x);
}

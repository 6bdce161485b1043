// Dawn: takes it
// Umbrage: is aligned to 32 by `@align` within its type
struct Inner { @align(32) x: f32 }
struct Outer { z: f32, inner: Inner }
@group(0) @binding(0) var<storage> given: Outer;
@fragment fn fs() -> @location(0) vec4f {
    return vec4f(given.inner.x);
}

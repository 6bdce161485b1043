// Dawn: takes it
@group(0) @binding(0) var t0: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(1) var t1: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(2) var t2: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(3) var t3: texture_storage_2d<rgba8unorm, write>;
@fragment fn fs() -> @location(0) vec4f {
    var sum = vec4f();
    textureStore(t0, vec2i(), sum);
    textureStore(t1, vec2i(), sum);
    textureStore(t2, vec2i(), sum);
    textureStore(t3, vec2i(), sum);
    return sum;
}

// Dawn: takes it
@group(0) @binding(0) var t0: texture_2d<f32>;
@group(0) @binding(1) var t1: texture_2d<f32>;
@group(0) @binding(2) var t2: texture_2d<f32>;
@group(0) @binding(3) var t3: texture_2d<f32>;
@group(0) @binding(4) var t4: texture_2d<f32>;
@group(0) @binding(5) var t5: texture_2d<f32>;
@group(0) @binding(6) var t6: texture_2d<f32>;
@group(0) @binding(7) var t7: texture_2d<f32>;
@group(0) @binding(8) var t8: texture_2d<f32>;
@group(0) @binding(9) var t9: texture_2d<f32>;
@group(0) @binding(10) var t10: texture_2d<f32>;
@group(0) @binding(11) var t11: texture_2d<f32>;
@group(0) @binding(12) var t12: texture_2d<f32>;
@group(0) @binding(13) var t13: texture_2d<f32>;
@group(0) @binding(14) var t14: texture_2d<f32>;
@group(0) @binding(15) var t15: texture_2d<f32>;
@fragment fn fs() -> @location(0) vec4f {
    var sum = vec4f();
    sum += textureLoad(t0, vec2i(), 0);
    sum += textureLoad(t1, vec2i(), 0);
    sum += textureLoad(t2, vec2i(), 0);
    sum += textureLoad(t3, vec2i(), 0);
    sum += textureLoad(t4, vec2i(), 0);
    sum += textureLoad(t5, vec2i(), 0);
    sum += textureLoad(t6, vec2i(), 0);
    sum += textureLoad(t7, vec2i(), 0);
    sum += textureLoad(t8, vec2i(), 0);
    sum += textureLoad(t9, vec2i(), 0);
    sum += textureLoad(t10, vec2i(), 0);
    sum += textureLoad(t11, vec2i(), 0);
    sum += textureLoad(t12, vec2i(), 0);
    sum += textureLoad(t13, vec2i(), 0);
    sum += textureLoad(t14, vec2i(), 0);
    sum += textureLoad(t15, vec2i(), 0);
    return sum;
}

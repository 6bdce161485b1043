// Dawn: refuses it: the component argument must be at least 0 and at most 3. component is 4
// Umbrage: textureGather component `4` doesn't exist, must be 0, 1, 2, or 3
@group(0) @binding(0) var t: texture_2d<f32>;
@group(0) @binding(1) var s: sampler;
@group(0) @binding(2) var d: texture_depth_2d;
@group(0) @binding(3) var c: sampler_comparison;
@fragment fn fs(@builtin(position) at: vec4f) -> @location(0) vec4f {
    return vec4f(textureGather(4, t, s, at.xy));
}

// Dawn: takes it
@group(0) @binding(0) var<storage> s: array<f32>;
@vertex fn vs() -> @builtin(position) vec4f {
    return vec4f(s[0]);
}

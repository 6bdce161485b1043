// Dawn: takes it
@group(0) @binding(0) var<storage, read_write> s: array<f32>;
@fragment fn fs() {
    s[0] = 1.0;
}

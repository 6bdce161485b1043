// Dawn: takes it
@fragment fn fs() -> @builtin(frag_depth) f32 {
    return 0.5;
}

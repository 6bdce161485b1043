// Dawn: takes it
@fragment fn fs() -> @builtin(sample_mask) u32 {
    return 1u;
}

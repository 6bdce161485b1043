// Dawn: takes it
@fragment fn fs(@builtin(sample_index) i: u32) {}

// Dawn: takes it
@group(0) @binding(0) var<storage, read_write> s: atomic<u32>;
@fragment fn fs() {
    atomicAdd(&s, 1u);
}

// Dawn: refuses it: atomic variables in 'storage' address space must have 'read_write' access mode
// Umbrage: `read_write`
@group(0) @binding(0) var<storage, read> s: atomic<u32>;
@fragment fn fs() {
    let a = atomicLoad(&s);
}

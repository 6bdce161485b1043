// Dawn: refuses it: cannot store into a read-only type 'ref<storage, u32, read>'
// Umbrage: this cannot be assigned to
@group(0) @binding(0) var<storage> s: array<u32>;
@fragment fn fs() {
    s[0] = 1u;
}

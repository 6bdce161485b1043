// Dawn: refuses it: built-in cannot be used by vertex pipeline stage
// Umbrage: uses operations forbidden at this stage
@vertex fn vs(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {
    return vec4f(dpdx(f32(i)));
}

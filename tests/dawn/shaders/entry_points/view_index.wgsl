// Dawn: refuses it: use of '@builtin(view_index)' requires enabling extension 'view_instancing'
// Umbrage: the built-in value `view_index` is none of WGSL's, and what some devices offer beyond it modules cannot ask for
@vertex fn vs(@builtin(view_index) i: u32) -> @builtin(position) vec4f {
    return vec4f(f32(i));
}

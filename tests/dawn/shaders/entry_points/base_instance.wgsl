// Dawn: refuses it: expected builtin value name
// Umbrage: the built-in value `base_instance` is none of WGSL's, and what some devices offer beyond it modules cannot ask for
@vertex fn vs(@builtin(base_instance) i: u32) -> @builtin(position) vec4f {
    return vec4f(f32(i));
}

// Dawn: refuses it: use of '@builtin(view_index)' requires enabling extension 'view_instancing'
@vertex fn vs(@builtin(view_index) i: u32) -> @builtin(position) vec4f {
    return vec4f(f32(i));
}

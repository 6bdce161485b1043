// Dawn: refuses it: expected builtin value name
@vertex fn vs(@builtin(base_instance) i: u32) -> @builtin(position) vec4f {
    return vec4f(f32(i));
}

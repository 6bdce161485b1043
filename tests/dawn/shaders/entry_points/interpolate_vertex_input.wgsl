// Dawn: takes it
@vertex fn vs(@location(0) @interpolate(flat) a: u32) -> @builtin(position) vec4f {
    return vec4f(f32(a));
}

// Dawn: takes it
@vertex fn vs(@location(15) x: f32) -> @builtin(position) vec4f {
    return vec4f(x);
}

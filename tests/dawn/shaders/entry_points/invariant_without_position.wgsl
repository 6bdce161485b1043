// Dawn: refuses it: '@invariant' must be applied to a '@builtin(position)'
@vertex fn vs() -> @invariant @location(0) vec4f {
    return vec4f();
}

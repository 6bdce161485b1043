// Dawn: refuses it: '@invariant' must be applied to a '@builtin(position)'
// Umbrage: input/output binding is not consistent
@vertex fn vs() -> @invariant @location(0) vec4f {
    return vec4f();
}

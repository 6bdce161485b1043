// Dawn: refuses it: a vertex shader must include the 'position' builtin in its return type
// Umbrage: vertex shaders must return a `@builtin(position)` output value
@vertex fn vs() -> @location(0) vec4f {
    return vec4f();
}

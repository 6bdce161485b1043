// Dawn: refuses it: a vertex shader must include the 'position' builtin in its return type
@vertex fn vs() -> @location(0) vec4f {
    return vec4f();
}

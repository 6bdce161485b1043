// Dawn: takes it
@vertex fn vs() -> @builtin(position) @invariant vec4f {
    return vec4f();
}

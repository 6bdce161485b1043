// Dawn: refuses it: discard statement cannot be used in vertex pipeline stage
// Umbrage: uses operations forbidden at this stage
@vertex fn vs() -> @builtin(position) vec4f {
    discard;
    return vec4f();
}

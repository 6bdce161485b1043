// Dawn: refuses it: missing return at end of function
// Umbrage: may end without a value
fn f() -> f32 {
    discard;
}
@fragment fn fs() -> @location(0) vec4f {
    return vec4f(f());
}

// Dawn: refuses it: nested structures cannot be used for entry point IO
// Umbrage: a member of the struct has neither `@location` nor `@builtin`
struct A {
    @location(0) a: f32,
}
struct B {
    a: A,
}
@fragment fn fs(b: B) {}

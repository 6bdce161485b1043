// Dawn: refuses it: nested structures cannot be used for entry point IO
struct A {
    @location(0) a: f32,
}
struct B {
    a: A,
}
@fragment fn fs(b: B) {}

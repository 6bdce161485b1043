// Dawn: refuses it: runtime arrays may only appear as the last member of a struct
// Umbrage: the member `a` has no fixed size; only the last of a storage buffer may have none
struct S {
    a: array<f32>,
    b: f32,
}
@group(0) @binding(0) var<storage> s: S;
@fragment fn fs() {
    let a = s.b;
}

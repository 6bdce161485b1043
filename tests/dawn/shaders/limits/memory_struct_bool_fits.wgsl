// Dawn: takes it
struct S { a: bool, b: f32 }
var<workgroup> w: array<S, 2048>;
@compute @workgroup_size(1) fn cs() {
    w[0].a = true;
}

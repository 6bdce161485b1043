// Dawn: refuses it: invalid aliased pointer argument
// Umbrage: point into `s`
struct S { x: i32, y: i32 }
fn f(a: ptr<function, i32>, b: ptr<function, i32>) {
    *a = *b;
}
@compute @workgroup_size(1) fn cs() {
    var s: S;
    f(&s.x, &s.y);
}

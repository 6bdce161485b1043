// Dawn: refuses it: index -1 out of bounds
// Umbrage: the index -1 is negative
@group(0) @binding(0) var<storage> s: array<f32>;
@compute @workgroup_size(1) fn cs() {
    let r = s[-1];
}

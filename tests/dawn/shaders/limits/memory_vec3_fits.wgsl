// Dawn: takes it
var<workgroup> w: array<vec3f, 1024>;
@compute @workgroup_size(1) fn cs() {
    w[0] = vec3f();
}

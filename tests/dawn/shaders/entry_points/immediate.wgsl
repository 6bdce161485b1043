// Dawn: takes it
// Umbrage: address space
var<immediate> p: vec4f;
@fragment fn fs() -> @location(0) vec4f {
    return p;
}

// Dawn: refuses it: loop does not exit
// Umbrage: no exit
@fragment fn fs() -> @location(0) vec4f {
    loop {
        discard;
    }
    return vec4f();
}

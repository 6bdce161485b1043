// Dawn: refuses it: storage texture with 'read_write' access mode cannot be used by vertex pipeline stage
// Umbrage: storage texture `s`
@group(0) @binding(0) var s: texture_storage_2d<r32float, read_write>;
@vertex fn vs() -> @builtin(position) vec4f {
    return vec4f(textureLoad(s, vec2i()));
}

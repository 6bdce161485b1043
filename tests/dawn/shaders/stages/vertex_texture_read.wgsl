// Dawn: takes it
@group(0) @binding(0) var s: texture_storage_2d<r32float, read>;
@vertex fn vs() -> @builtin(position) vec4f {
    return vec4f(textureLoad(s, vec2i()));
}

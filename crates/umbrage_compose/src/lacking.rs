//! Capabilities that a shader needs and its target lacks, in words.

use naga::{
    Module,
    valid::{Capabilities, ValidationFlags, Validator},
};

use crate::Target;

/// Capabilities that `module` needs beyond those of `target`: without them, the module is refused as it is now;
/// with them, it is valid or refused for another reason. Found by leaving out one at a time, so the set is not
/// always the smallest.
pub(crate) fn lacking(module: &Module, target: &Target) -> Capabilities {
    let refusal = |capabilities: Capabilities| {
        let mut validator = Validator::new(ValidationFlags::all(), capabilities);
        validator.validate(module).err().map(|error| {
            let spans: Vec<_> = error.spans().map(|(span, _)| span.to_range()).collect();
            (format!("{:?}", error.as_inner()), spans)
        })
    };
    let with_all = refusal(Capabilities::all());
    if with_all == refusal(target.capabilities()) {
        return Capabilities::empty();
    }
    let mut needed = Capabilities::all();
    let offered = target.capabilities();
    // A stronger capability comes after a weaker one, so going backwards leaves out the stronger one first.
    let beyond: Vec<_> = Capabilities::all().difference(offered).iter().collect();
    for one in beyond.into_iter().rev() {
        let without = needed.difference(one);
        if refusal(without) == with_all {
            needed = without;
        }
    }
    needed.difference(offered)
}

/// Message and advice for a fault about the `lacking` capabilities; none where nothing is lacking.
pub(crate) fn told(lacking: Capabilities, target: &Target) -> Option<(String, String)> {
    let mut whats = Vec::new();
    let mut features = Vec::new();
    for one in lacking.iter() {
        let (what, feature) = described(one);
        whats.push(what);
        if !feature.is_empty() && !features.contains(&feature) {
            features.push(feature);
        }
    }
    let whats: Vec<_> = whats.into_iter().filter(|what| !what.is_empty()).collect();
    if whats.is_empty() {
        return None;
    }
    let advice = match features.as_slice() {
        [] => "do without, or choose a target that offers it".to_owned(),
        [one] => format!("do without, or choose a target whose devices have the feature `{one}`"),
        all => format!(
            "do without, or choose a target whose devices have the features `{}`",
            all.join("`, `")
        ),
    };
    let message = format!(
        "this needs {}, which the target `{target}` does not offer",
        whats.join(" and ")
    );
    Some((message, advice))
}

/// Name of `capability` (a single flag), and the device feature that offers it: WebGPU's features in lower case,
/// wgpu's in capitals.
fn described(capability: Capabilities) -> (&'static str, &'static str) {
    type C = Capabilities;
    match capability {
        C::IMMEDIATES => ("immediates (`var<immediate>`)", "IMMEDIATES"),
        C::FLOAT64 => ("64-bit floats (`f64`)", "SHADER_F64"),
        C::PRIMITIVE_INDEX => ("`@builtin(primitive_index)`", "primitive-index"),
        C::TEXTURE_AND_SAMPLER_BINDING_ARRAY => (
            "a `binding_array` of textures or samplers",
            "TEXTURE_BINDING_ARRAY",
        ),
        C::BUFFER_BINDING_ARRAY => (
            "a `binding_array` of uniform buffers",
            "BUFFER_BINDING_ARRAY",
        ),
        C::STORAGE_TEXTURE_BINDING_ARRAY => (
            "a `binding_array` of storage textures",
            "STORAGE_RESOURCE_BINDING_ARRAY",
        ),
        C::STORAGE_BUFFER_BINDING_ARRAY => (
            "a `binding_array` of storage buffers",
            "STORAGE_RESOURCE_BINDING_ARRAY",
        ),
        C::CLIP_DISTANCES => ("`@builtin(clip_distances)`", "clip-distances"),
        C::CULL_DISTANCE => ("`@builtin(cull_distance)`", ""),
        C::STORAGE_TEXTURE_16BIT_NORM_FORMATS => (
            "storage textures of 16-bit normalized formats",
            "TEXTURE_FORMAT_16BIT_NORM",
        ),
        C::MULTIVIEW => ("`@builtin(view_index)`", "MULTIVIEW"),
        C::EARLY_DEPTH_TEST => ("`@early_depth_test`", "SHADER_EARLY_DEPTH_TEST"),
        C::MULTISAMPLED_SHADING => ("shading of each sample (`@builtin(sample_index)`)", ""),
        C::RAY_QUERY => ("ray queries", "EXPERIMENTAL_RAY_QUERY"),
        C::DUAL_SOURCE_BLENDING => (
            "blending of two sources (`@blend_src`)",
            "dual-source-blending",
        ),
        C::CUBE_ARRAY_TEXTURES => ("arrays of cube textures", ""),
        C::SHADER_INT64 => ("64-bit integers (`i64`, `u64`)", "SHADER_INT64"),
        C::SUBGROUP => ("subgroup operations", "subgroups"),
        C::SUBGROUP_BARRIER => ("subgroup barriers", "SUBGROUP_BARRIER"),
        C::SUBGROUP_VERTEX_STAGE => ("subgroup operations in the vertex stage", "SUBGROUP_VERTEX"),
        C::SHADER_INT64_ATOMIC_MIN_MAX => (
            "`atomicMin` and `atomicMax` on 64-bit integers",
            "SHADER_INT64_ATOMIC_MIN_MAX",
        ),
        C::SHADER_INT64_ATOMIC_ALL_OPS => {
            ("atomics on 64-bit integers", "SHADER_INT64_ATOMIC_ALL_OPS")
        }
        C::SHADER_FLOAT32_ATOMIC => ("atomics on `f32`", "SHADER_FLOAT32_ATOMIC"),
        C::TEXTURE_ATOMIC => ("atomics on textures", "TEXTURE_ATOMIC"),
        C::TEXTURE_INT64_ATOMIC => ("64-bit atomics on textures", "TEXTURE_INT64_ATOMIC"),
        C::RAY_HIT_VERTEX_POSITION => (
            "the vertices that a ray hits",
            "EXPERIMENTAL_RAY_HIT_VERTEX_RETURN",
        ),
        C::SHADER_FLOAT16 => ("half-precision floats (`f16`)", "shader-f16"),
        C::TEXTURE_EXTERNAL => ("`texture_external`", "EXTERNAL_TEXTURE"),
        C::SHADER_FLOAT16_IN_FLOAT32 => {
            ("`quantizeToF16`, `pack2x16float` and `unpack2x16float`", "")
        }
        C::SHADER_BARYCENTRICS => ("`@builtin(barycentric)`", "SHADER_BARYCENTRICS"),
        C::MESH_SHADER => ("task and mesh shaders", "EXPERIMENTAL_MESH_SHADER"),
        C::MESH_SHADER_POINT_TOPOLOGY => (
            "mesh shaders that make points",
            "EXPERIMENTAL_MESH_SHADER_POINTS",
        ),
        C::TEXTURE_AND_SAMPLER_BINDING_ARRAY_NON_UNIFORM_INDEXING => (
            "an index that is not uniform into a `binding_array` of textures or samplers",
            "SAMPLED_TEXTURE_AND_STORAGE_BUFFER_ARRAY_NON_UNIFORM_INDEXING",
        ),
        C::BUFFER_BINDING_ARRAY_NON_UNIFORM_INDEXING => (
            "an index that is not uniform into a `binding_array` of uniform buffers",
            "UNIFORM_BUFFER_BINDING_ARRAYS",
        ),
        C::STORAGE_TEXTURE_BINDING_ARRAY_NON_UNIFORM_INDEXING => (
            "an index that is not uniform into a `binding_array` of storage textures",
            "STORAGE_TEXTURE_ARRAY_NON_UNIFORM_INDEXING",
        ),
        C::STORAGE_BUFFER_BINDING_ARRAY_NON_UNIFORM_INDEXING => (
            "an index that is not uniform into a `binding_array` of storage buffers",
            "SAMPLED_TEXTURE_AND_STORAGE_BUFFER_ARRAY_NON_UNIFORM_INDEXING",
        ),
        C::COOPERATIVE_MATRIX => ("cooperative matrices", "EXPERIMENTAL_COOPERATIVE_MATRIX"),
        C::PER_VERTEX => ("fragment inputs by vertex", "SHADER_PER_VERTEX"),
        C::RAY_TRACING_PIPELINE => (
            "stages of a ray tracing pipeline",
            "EXPERIMENTAL_RAY_TRACING_PIPELINES",
        ),
        C::DRAW_INDEX => ("`@builtin(draw_index)`", "SHADER_DRAW_INDEX"),
        C::ACCELERATION_STRUCTURE_BINDING_ARRAY => (
            "a `binding_array` of acceleration structures",
            "ACCELERATION_STRUCTURE_BINDING_ARRAY",
        ),
        C::MEMORY_DECORATION_COHERENT => ("`@coherent`", "MEMORY_DECORATION_COHERENT"),
        C::MEMORY_DECORATION_VOLATILE => ("`@volatile`", "MEMORY_DECORATION_VOLATILE"),
        C::SHADER_INT16 => ("16-bit integers (`i16`, `u16`)", "SHADER_I16"),
        _ => ("", ""),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_capability_has_words() {
        for capability in Capabilities::all().iter() {
            let (what, _) = described(capability);
            assert!(!what.is_empty(), "{capability:?}");
        }
    }
}

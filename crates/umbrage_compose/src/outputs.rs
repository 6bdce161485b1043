//! Languages that a permutation can be written in, beside WGSL and SPIR-V.

use std::fmt;

use naga::{
    Module, ResourceBinding,
    back::{glsl, hlsl, msl},
    proc::BoundsCheckPolicies,
    valid::ModuleInfo,
};
use serde::{Deserialize, Serialize};

use crate::{Binding, BindingKind, Error, Permutation, Stage};

/// A language of shaders.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Language {
    /// WebGPU's own.
    Wgsl,
    /// Vulkan's: all entry points in one module. Overrides are constants at their defaults, as in all that follow.
    Spirv,
    /// Metal's, version 2.3: all entry points in one text. Buffers, textures and samplers are each numbered from 0, in the
    /// order of the reflection's bindings.
    Msl,
    /// Direct3D's, shader model 6.0: all entry points in one text; a group is a space, and a binding a register in it.
    Hlsl,
    /// OpenGL ES's, version 3.10: a text for each entry point. Buffers of each kind, textures and images are each numbered
    /// from 0, in the order of the reflection's bindings.
    Glsl,
}

/// A permutation, or one of its entry points, in some language.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Output {
    /// The entry point, where the text has one alone.
    pub entry_point: Option<String>,
    /// The text, or SPIR-V's words with the lowest byte first.
    pub bytes: Vec<u8>,
}

impl Language {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Wgsl, Self::Spirv, Self::Msl, Self::Hlsl, Self::Glsl];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Wgsl => "wgsl",
            Self::Spirv => "spirv",
            Self::Msl => "msl",
            Self::Hlsl => "hlsl",
            Self::Glsl => "glsl",
        }
    }

    /// How names of its files end, without the dot.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Wgsl => "wgsl",
            Self::Spirv => "spv",
            Self::Msl => "metal",
            Self::Hlsl => "hlsl",
            Self::Glsl => "glsl",
        }
    }
}

impl fmt::Display for Language {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl Permutation {
    /// The shader in `language`.
    ///
    /// # Errors
    /// Code that the language cannot say, or naga's writer of it; outside WGSL, an override without a default, or with an
    /// invalid default.
    pub fn outputs(&self, language: Language) -> Result<Vec<Output>, Error> {
        let whole = |bytes| {
            vec![Output {
                entry_point: None,
                bytes,
            }]
        };
        if language == Language::Wgsl {
            return Ok(whole(self.wgsl()?.into_bytes()));
        }
        if language == Language::Spirv {
            let words = self.spirv()?.into_iter();
            return Ok(whole(words.flat_map(u32::to_le_bytes).collect()));
        }
        let (module, info) = self.at_defaults(language)?;
        match language {
            Language::Msl => {
                let options = msl_options(&module, &self.reflection.bindings);
                let written =
                    msl::write_string(&module, &info, &options, &msl::PipelineOptions::default());
                match written {
                    Ok((text, _)) => Ok(whole(text.into_bytes())),
                    Err(error) => Err(self.unwritable("MSL", &error)),
                }
            }
            Language::Hlsl => {
                let written = hlsl_text(&module, &info);
                let text = written.map_err(|error| self.unwritable("HLSL", &error))?;
                Ok(whole(text.into_bytes()))
            }
            _ => {
                let texts = module.entry_points.iter().map(|entry| {
                    let pipeline = glsl::PipelineOptions {
                        shader_stage: entry.stage,
                        entry_point: entry.name.clone(),
                        multiview: None,
                    };
                    let text = glsl_text(&module, &info, &pipeline, &self.reflection.bindings);
                    let text = text.map_err(|error| self.unwritable("GLSL", &error))?;
                    Ok(Output {
                        entry_point: Some(entry.name.clone()),
                        bytes: text.into_bytes(),
                    })
                });
                texts.collect()
            }
        }
    }
}

fn at(binding: &Binding) -> ResourceBinding {
    ResourceBinding {
        group: binding.group,
        binding: binding.binding,
    }
}

fn msl_options(module: &Module, bindings: &[Binding]) -> msl::Options {
    let mut resources = msl::EntryPointResources::default();
    let (mut buffers, mut textures, mut samplers) = (0, 0, 0);
    let next = |count: &mut u8| {
        let number = *count;
        *count = count.saturating_add(1);
        number
    };
    for binding in bindings {
        let mut target = msl::BindTarget::default();
        match &binding.kind {
            BindingKind::Uniform(_) => target.buffer = Some(next(&mut buffers)),
            BindingKind::Storage { read_only, .. } => {
                target.buffer = Some(next(&mut buffers));
                target.mutable = !read_only;
            }
            BindingKind::Texture { .. } => target.texture = Some(next(&mut textures)),
            BindingKind::StorageTexture { write, .. } => {
                target.texture = Some(next(&mut textures));
                target.mutable = *write;
            }
            BindingKind::Sampler { .. } => {
                target.sampler = Some(msl::BindSamplerTarget::Resource(next(&mut samplers)));
            }
        }
        resources.resources.insert(at(binding), target);
    }
    // Lengths of run-time arrays come after all other buffers.
    resources.sizes_buffer = Some(buffers);
    let entries = module.entry_points.iter();
    msl::Options {
        lang_version: (2, 3),
        per_entry_point_map: entries
            .map(|entry| (entry.name.clone(), resources.clone()))
            .collect(),
        fake_missing_bindings: false,
        ..msl::Options::default()
    }
}

fn hlsl_text(module: &Module, info: &ModuleInfo) -> Result<String, hlsl::Error> {
    let options = hlsl::Options {
        shader_model: hlsl::ShaderModel::V6_0,
        fake_missing_bindings: true,
        ..hlsl::Options::default()
    };
    let pipeline = hlsl::PipelineOptions::default();
    let mut text = String::new();
    hlsl::Writer::new(&mut text, &options, &pipeline).write(module, info, None)?;
    Ok(text)
}

fn glsl_text(
    module: &Module,
    info: &ModuleInfo,
    pipeline: &glsl::PipelineOptions,
    bindings: &[Binding],
) -> Result<String, glsl::Error> {
    let mut options = glsl::Options {
        version: glsl::Version::Embedded {
            version: 310,
            is_webgl: false,
        },
        ..glsl::Options::default()
    };
    let mut counts = [0u8; 4];
    for binding in bindings {
        let kind = match &binding.kind {
            BindingKind::Uniform(_) => 0,
            BindingKind::Storage { .. } => 1,
            BindingKind::Texture { .. } => 2,
            BindingKind::StorageTexture { .. } => 3,
            // A sampler is one with the textures that it samples.
            BindingKind::Sampler { .. } => continue,
        };
        options.binding_map.insert(at(binding), counts[kind]);
        counts[kind] = counts[kind].saturating_add(1);
    }
    let mut text = String::new();
    let bounds = BoundsCheckPolicies::default();
    glsl::Writer::new(&mut text, module, info, &options, pipeline, bounds)?.write()?;
    Ok(text)
}

/// The stage's name in names of files, as tools know it.
pub(crate) fn stage_name(stage: Stage) -> &'static str {
    match stage {
        Stage::Vertex => "vert",
        Stage::Fragment => "frag",
        Stage::Compute => "comp",
    }
}

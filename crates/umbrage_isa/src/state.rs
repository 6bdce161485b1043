//! How a pass draws, apart from its shader, so far as that changes what the shader is compiled to.

use umbrage_compose::{Depth, Factor, Permutation, Stage};
use wgpu_types::{
    BlendComponent, BlendFactor, BlendOperation, BlendState, CompareFunction, Face, FrontFace,
    TextureFormat,
};

/// How a pass draws: triangles, one sample a pixel. Vertex attributes and bindings are not said here: they
/// follow from the permutation. Stencil and depth bias change nothing in a shader, and are left out. An output
/// without a target the compiler leaves out, with all that it was computed from.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PipelineState {
    /// The colour targets, by the locations that the fragment stage writes; none where one is skipped.
    pub colors: Vec<Option<ColorTarget>>,
    /// The depth target.
    pub depth: Option<DepthTarget>,
    /// The side of triangles that is not drawn.
    pub cull: Option<Face>,
    /// Front side of a triangle.
    pub front: FrontFace,
}

/// A colour target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ColorTarget {
    /// Its format.
    pub format: TextureFormat,
    /// How what is drawn meets what is there; without it, it takes its place.
    pub blend: Option<BlendState>,
}

/// A depth target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DepthTarget {
    /// Its format.
    pub format: TextureFormat,
    /// Comparison of new and old depth that lets a fragment through.
    pub compare: CompareFunction,
    /// Whether the new depth is kept.
    pub write: bool,
}

impl PipelineState {
    /// The plainest pass that takes what `permutation` gives: for each output of the fragment stage a
    /// target of its type, 16 bits a channel where it has four and 32 where it has fewer, no blending;
    /// depth in 32 bits, reversed, written; nothing culled. For hosts that do not say what they do.
    pub fn plain(permutation: &Permutation) -> Self {
        Self {
            colors: outputs(permutation),
            depth: Some(DepthTarget {
                format: TextureFormat::Depth32Float,
                compare: CompareFunction::GreaterEqual,
                write: true,
            }),
            ..Self::default()
        }
    }

    /// As the pass that `permutation` is of is run, so far as its axes tell: plainly where they do not.
    pub fn of(permutation: &Permutation) -> Self {
        let mut state = Self::plain(permutation);
        let Some(pass) = permutation.pass else {
            return state;
        };
        let blend = pass.blend.factors().map(blend);
        for color in state.colors.iter_mut().flatten() {
            color.blend = blend;
        }
        state.depth = state.depth.filter(|_| pass.depth != Depth::Ignored);
        if let Some(depth) = &mut state.depth {
            depth.write = pass.depth == Depth::Written;
        }
        state
    }
}

/// The sum of what is drawn and what is there, times their factors.
fn blend(factors: [Factor; 2]) -> BlendState {
    let [src_factor, dst_factor] = factors.map(|factor| match factor {
        Factor::Zero => BlendFactor::Zero,
        Factor::One => BlendFactor::One,
        Factor::Drawn => BlendFactor::Src,
    });
    let sum = BlendComponent {
        src_factor,
        dst_factor,
        operation: BlendOperation::Add,
    };
    BlendState {
        color: sum,
        alpha: sum,
    }
}

/// A target for each of the fragment stage's outputs.
fn outputs(permutation: &Permutation) -> Vec<Option<ColorTarget>> {
    let name = permutation.reflection.entry_point(Stage::Fragment);
    let module = &permutation.module;
    let result = name
        .and_then(|name| module.entry_points.iter().find(|e| e.name == name.name))
        .and_then(|entry| entry.function.result.as_ref());
    let Some(result) = result else {
        return Vec::new();
    };
    let members = match (&result.binding, &module.types[result.ty].inner) {
        (Some(binding), _) => vec![(binding, result.ty)],
        (None, naga::TypeInner::Struct { members, .. }) => members
            .iter()
            .filter_map(|member| Some((member.binding.as_ref()?, member.ty)))
            .collect(),
        _ => Vec::new(),
    };
    let mut targets = Vec::new();
    for (binding, ty) in members {
        let naga::Binding::Location { location, .. } = binding else {
            continue;
        };
        let location = *location as usize;
        if targets.len() <= location {
            targets.resize(location + 1, None);
        }
        let format = format(&module.types[ty].inner);
        targets[location] = format.map(|format| ColorTarget {
            format,
            blend: None,
        });
    }
    targets
}

fn format(ty: &naga::TypeInner) -> Option<TextureFormat> {
    use naga::ScalarKind::{Float, Sint, Uint};
    let (size, kind) = match ty {
        naga::TypeInner::Scalar(scalar) => (1, scalar.kind),
        naga::TypeInner::Vector { size, scalar } => (*size as u8, scalar.kind),
        _ => return None,
    };
    Some(match (kind, size) {
        (Float, 1) => TextureFormat::R32Float,
        (Float, 2) => TextureFormat::Rg32Float,
        (Float, _) => TextureFormat::Rgba16Float,
        (Uint, 1) => TextureFormat::R32Uint,
        (Uint, 2) => TextureFormat::Rg32Uint,
        (Uint, _) => TextureFormat::Rgba16Uint,
        (Sint, 1) => TextureFormat::R32Sint,
        (Sint, 2) => TextureFormat::Rg32Sint,
        (Sint, _) => TextureFormat::Rgba16Sint,
        _ => return None,
    })
}

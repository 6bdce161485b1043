//! What is written about the methods: figures of error beside figures of cost.

use serde::Serialize;

use crate::figures::Figures;

pub use umbrage_isa::Isa;

/// One scene, drawn by one method in one configuration along one path.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// The scene's name.
    pub scene: String,
    /// The method's name.
    pub method: String,
    /// The configuration's name.
    pub config: String,
    /// How the shadow term reached the surface: `forward`.
    pub path: String,
    /// The errors.
    #[serde(flatten)]
    pub figures: Figures,
    /// Time of the caster passes, milliseconds.
    pub casters_ms: Spread,
    /// Time of the shading, milliseconds.
    pub shading_ms: Spread,
    /// Casters and shading over those of `basic` with one tap in the same run.
    pub time_ratio: f64,
    /// Bytes in the method's textures.
    pub memory_bytes: u64,
    /// Texels in them.
    pub texels: u64,
    /// Passes that draw casters.
    pub passes: u32,
    /// Draw calls in them.
    pub draws: u32,
    /// Texture fetches of `calc_shadow` a pixel, counted on the device, mean over the compared pixels.
    pub fetches_per_pixel: f64,
    /// What a GPU's compiler makes of the costliest fragment shader; none where that compiler is missing.
    pub isa: Option<Isa>,
    /// Whether no other configuration of the scene is at once no worse and somewhere better, in error
    /// and time or in error and memory.
    pub pareto: bool,
}

/// A median and how far the measurements spread.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Spread {
    /// The least.
    pub min: f64,
    /// The median.
    pub median: f64,
    /// The greatest.
    pub max: f64,
}

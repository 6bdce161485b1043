//! How far a rendered shadow term is from the truth.

use serde::Serialize;

/// The error of one rendering of a scene. A *sample* is a pixel in one light; samples of all lights are
/// pooled. Shares are of the compared samples, 0 to 1; none where nothing in the picture has a figure.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Figures {
    /// Samples that were compared: something is seen there, and the light reaches it.
    pub compared: u64,
    /// Samples left out as the rasteriser saw another triangle than the ray.
    pub left_out: u64,
    /// Share that is lit (above ½) but should not be.
    pub false_lit: f64,
    /// Share that is in shadow (below ½) but should not be.
    pub false_shadow: f64,
    /// False shadow that no true edge explains: the receiver shades itself.
    pub acne: f64,
    /// False light where the nearest thing in the light's way is within the bias's and the filter's
    /// reach of the receiver: the shadow's band at the contact.
    pub detachment: f64,
    /// False light far from an edge and from a contact: behind a caster.
    pub leak: f64,
    /// False light beyond the method's shadow distance.
    pub beyond_range: f64,
    /// False light and false shadow within a filter's reach of a true edge: the map's resolution.
    pub edge: f64,
    /// Root of the mean squared error of the shadow term.
    pub rmse: f64,
    /// The error of the shadow term that 99 of 100 samples do not exceed.
    pub p99: f64,
    /// Median distance from each true shadow edge to the nearest rendered one, and back; pixels.
    pub edge_p50: Option<f64>,
    /// The distance that 95 of 100 do not exceed; pixels.
    pub edge_p95: Option<f64>,
    /// The greatest distance; pixels.
    pub edge_max: Option<f64>,
    /// How many pixels a shadow texel covers across, d / d_i: what 95 of 100 samples do not exceed.
    pub alias_p95: Option<f64>,
    /// Share of the samples that face the light where a texel covers more than one pixel.
    pub alias_over_1: Option<f64>,
    /// 95th percentile of the perspective part of d / d_i.
    pub alias_perspective_p95: Option<f64>,
    /// 95th percentile of the projection part of d / d_i.
    pub alias_projection_p95: Option<f64>,
    /// Share of the samples that flip from one frame to the next under a small motion of the camera,
    /// less those that flip in truth.
    pub shimmer: Option<f64>,
    /// Mean FLIP of the shaded picture against the picture with true shadows; 0 alike to 1.
    pub flip: Option<f64>,
    /// Samples that are not a number, infinite, or outside 0..1.
    pub bad_pixels: u64,
}

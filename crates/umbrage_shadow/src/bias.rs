//! Bias: what keeps a map's receivers from shading themselves.

use glam::DVec2;

use crate::{Extent, Lens};

/// Bias of a map's receivers, which keeps them from shading themselves. Depth is reversed: 1 near the light, 0 far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bias {
    /// Bias of a receiver's depth d, x + y · d: so many `texels` towards the light.
    pub depth: DVec2,
    /// The width of a texel at depth d is x + y · d, as a depth.
    pub texel: DVec2,
    /// The bias in texels' widths: what was chosen, and what rounding may be.
    pub texels: f64,
    /// The share of it that is for rounding.
    pub rounding: f64,
}

impl Bias {
    /// A bias of `texels` for a map of what is `seen` through `lens`, whose texels are `texel` wide in the lens's
    /// plane. `nearest` is the least distance of a receiver from a light with a perspective, metres.
    ///
    /// Without a perspective a texel is as wide everywhere. With one, it is `texel` · d wide at the distance d from the
    /// light, so that a shift by `texels` is one by a share s = `texels` · `texel` of d; rounding adds to s, and is worst for
    /// the nearest receiver. One over the distance grows by this share, s / (1 − s), and so does depth − A, as depth is A +
    /// B / d, and falls by B / d² a metre.
    pub fn new(lens: &Lens, seen: &Extent, texels: f64, texel: f64, nearest: f64) -> Self {
        if !lens.is_perspective() {
            let range = seen.far - seen.near;
            let far = seen.near.abs().max(seen.far.abs());
            let rounding = 4.0 * seen.precision().max(Extent::PRECISION * far);
            let shift = texels * texel + rounding;
            return Self {
                depth: DVec2::new(shift / range, 0.0),
                texel: DVec2::new(texel / range, 0.0),
                texels: shift / texel,
                rounding: rounding / texel,
            };
        }
        // Beyond the whole distance a shift has no meaning.
        let most = 0.9;
        let rounding = Extent::PRECISION + seen.precision() / nearest.max(1e-3 * seen.far);
        let rounding = (4.0 * rounding).min(most);
        let share = (texels * texel + rounding).min(most);
        let risen = DVec2::new(-lens.depth_terms(seen.near, seen.far).x, 1.0);
        Self {
            depth: share / (1.0 - share) * risen,
            texel: texel * risen,
            texels: share / texel,
            rounding: rounding / texel,
        }
    }
}

//! Why samples are wrong.

use std::cmp::Ordering;

use umbrage_shadow::ShadowPlan;

use super::{
    alias::Texel,
    edges::{Edges, Side},
    surface::Surface,
};

/// Data of one light's samples, pixel by pixel.
pub(super) struct Case<'a> {
    pub(super) surface: &'a Surface,
    pub(super) truth: &'a [Side],
    pub(super) rendered: &'a [Side],
    pub(super) gaps: &'a [Option<f64>],
    /// Whether no light reaches the eye.
    pub(super) back_facing: &'a [bool],
    pub(super) texels: &'a [Option<Texel>],
    pub(super) true_edges: &'a Edges,
    pub(super) plan: Option<&'a ShadowPlan>,
}

/// Why a sample is wrong. Every wrong sample has one cause.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Cause {
    Acne,
    BackFacing,
    PeterPanning,
    Leak,
    BeyondRange,
    Edge,
}

impl Case<'_> {
    /// The cause of each wrong sample.
    pub(super) fn causes(&self) -> Vec<Option<Cause>> {
        let pixels = 0..self.truth.len();
        let mut causes: Vec<_> = pixels.map(|pixel| self.cause(pixel)).collect();
        self.spread(&mut causes);
        causes
    }

    fn cause(&self, pixel: usize) -> Option<Cause> {
        let is_lit = match (self.truth[pixel]?, self.rendered[pixel]?) {
            (Ordering::Less, Ordering::Greater) => true,
            (Ordering::Greater, Ordering::Less) => false,
            _ => return None,
        };
        Some(if self.back_facing[pixel] {
            Cause::BackFacing
        } else if is_lit && self.is_beyond_range(pixel) {
            Cause::BeyondRange
        } else if is_lit && self.is_at_contact(pixel) {
            Cause::PeterPanning
        } else if self.is_at_edge(pixel) {
            Cause::Edge
        } else if is_lit {
            Cause::Leak
        } else {
            Cause::Acne
        })
    }

    fn is_beyond_range(&self, pixel: usize) -> bool {
        let depth = |at: usize| {
            let facet = self.surface.facets[at].as_ref()?;
            Some(facet.position.dot(self.surface.view.forward()))
        };
        let end = self.plan.and_then(|plan| plan.shadow_distance);
        end.is_some_and(|end| depth(pixel).is_some_and(|depth| depth > end))
    }

    /// Whether what is in the way is as near as the bias that the filter calls for: two texels, and as
    /// much more as the receiver rises over the filter's radius R and a texel. At the angle θ between
    /// normal and light, and a texel's width t, that is t (2 + (R + 1) tan θ), which is no more than
    /// t (R + 2) / cos θ for any R of ½ or more.
    fn is_at_contact(&self, pixel: usize) -> bool {
        let reach = |texel: &Texel| texel.width * (self.radius() + 2.0) * texel.slope;
        let reach = self.texels[pixel].as_ref().map(reach);
        self.gaps[pixel]
            .zip(reach)
            .is_some_and(|(gap, reach)| gap <= reach)
    }

    /// Whether a true edge is so near that the filter may read beyond it, or the picture's own pixels
    /// displace it.
    fn is_at_edge(&self, pixel: usize) -> bool {
        let texel = self.texels[pixel]
            .as_ref()
            .map_or(0.0, |texel| texel.pixels);
        self.true_edges.at_pixel(self.surface.column_row(pixel))
            <= (self.radius() + 1.0) * texel + 1.0
    }

    fn radius(&self) -> f64 {
        self.plan.map_or(0.0, |plan| plan.filter_radius)
    }

    /// A leak that goes over into a contact without a break is the contact's band: it is as wide as the
    /// method's bias makes it, which no plan tells.
    fn spread(&self, causes: &mut [Option<Cause>]) {
        let contact = |pixel: &usize| causes[*pixel] == Some(Cause::PeterPanning);
        let mut border: Vec<_> = (0..causes.len()).filter(contact).collect();
        while let Some(pixel) = border.pop() {
            for next in self.surface.around(pixel) {
                if causes[next] == Some(Cause::Leak) && self.surface.is_one(pixel, next) {
                    causes[next] = Some(Cause::PeterPanning);
                    border.push(next);
                }
            }
        }
    }
}

//! How far a rendered shadow term is from the truth. The crate's page lists the figures.

mod alias;
mod cause;
mod edges;
mod error;
mod flip;
mod shimmer;
mod surface;
#[cfg(test)]
mod tests;

use serde::Serialize;
use umbrage_render::Scene;
use umbrage_shadow::{Light, ShadowPlan};

use self::{
    alias::texels,
    cause::{Case, Cause},
    edges::{Edges, Side, side},
    surface::Surface,
};
pub use self::{
    alias::{Alias, aliasing},
    error::FigureError,
    flip::flip,
    shimmer::{Frame, Terms, shimmer},
};
use crate::truth::Sight;

/// Which pixels see something turned away from each light, so that none of its light reaches the eye: there, no shadow term is seen to
/// be wrong.
pub(crate) fn back_facing(scene: &Scene, sight: &Sight) -> Result<Vec<Vec<bool>>, FigureError> {
    let surface = Surface::new(scene, sight)?;
    let lights = scene.lights.iter();
    Ok(lights
        .map(|light| surface.back_facing(&light.light))
        .collect())
}

/// The error figures of a rendering; all but `shimmer` and `flip`. `raster` says what the
/// rasteriser saw in each pixel: the object, and its triangle.
///
/// # Errors
/// Pictures of another size than the sight's, a sight of another scene, a camera that cannot be used.
pub fn figures(
    scene: &Scene,
    sight: &Sight,
    raster: &[Option<(u32, u32)>],
    samples: &[Sample<'_>],
) -> Result<Figures, FigureError> {
    let pixels = sight.seen().len();
    FigureError::check(
        || "the rasteriser's picture".to_owned(),
        raster.len(),
        pixels,
    )?;
    for (light, sample) in samples.iter().enumerate() {
        let check = |what: &str, found: usize| {
            FigureError::check(|| format!("{what} of light {light}"), found, pixels)
        };
        check("the truth", sample.truth.len())?;
        check("the picture of gaps", sample.gaps.len())?;
        check("the rendered term", sample.rendered.len())?;
    }
    let surface = Surface::new(scene, sight)?;
    let mut pool = Pool::default();
    for sample in samples {
        pool.add(&surface, sample, |pixel| is_compared(sight, raster, pixel));
    }
    Ok(pool.figures())
}

/// One light's shadow term as rendered, beside what is true of it. All pictures are of the sight's size,
/// by rows from the top.
#[derive(Clone, Copy, Debug)]
pub struct Sample<'a> {
    /// The light.
    pub light: &'a Light,
    /// Terms in truth: [`Tracer::shadow`](crate::truth::Tracer::shadow).
    pub truth: &'a [Option<f32>],
    /// How far away what keeps the light off is: [`Tracer::gaps`](crate::truth::Tracer::gaps); metres.
    pub gaps: &'a [Option<f64>],
    /// Terms as rendered.
    pub rendered: &'a [f32],
    /// Plan of the light's method for this very view; none for a light without shadows.
    pub plan: Option<&'a ShadowPlan>,
}

/// The error of one rendering of a scene. A *sample* is a pixel in one light; samples of all lights are
/// pooled. Shares are of the compared samples, 0 to 1, and 0 where there are none; a figure is none
/// where nothing in the picture has it. A term is *lit* above ½ and *in shadow* below; a term of exactly ½
/// is neither, so that it is never wrong. Percentiles are by nearest rank: the least value that so many
/// of 100 do not exceed.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Figures {
    /// Samples that were compared: something is seen there, the light reaches it, and the rasteriser
    /// saw the same triangle as the ray.
    pub compared: u64,
    /// Samples left out as the rasteriser saw another triangle than the ray, or none.
    pub left_out: u64,
    /// Share that is lit but should not be, where somebody sees it: on what faces the light.
    pub false_lit: f64,
    /// Share that is in shadow but should not be, where somebody sees it.
    pub false_shadow: f64,
    /// Share that is in shadow in truth, on what faces the light.
    pub in_shadow: f64,
    /// `false_lit` over `in_shadow`: a picture that is mostly lit flatters every method. None where nothing is in shadow in truth.
    pub false_lit_of_shadow: Option<f64>,
    /// `false_lit` and `false_shadow` over `in_shadow`; none where nothing is in shadow in truth.
    pub error_of_shadow: Option<f64>,
    /// False shadow far from a true edge: the receiver shades itself. `acne`, `peter_panning`,
    /// `leak`, `beyond_range` and `edge` are shares too, and add up to `false_lit` and `false_shadow`.
    pub acne: f64,
    /// False light and false shadow on what is turned away from the light: no light reaches the eye from there, whatever a shadow
    /// says. Such samples can be wrong without being seen to be; no other figure but `compared`, `left_out`, `bad_pixels` and those of
    /// aliasing counts them.
    pub back_facing: f64,
    /// Peter-panning: false light where the nearest thing in the light's way is within the bias's and the filter's
    /// reach of the receiver, R + 2 texels' widths stretched by the receiver's slope (20 times at most),
    /// where R is the plan's filter radius; and what goes on from there without a break, as wide as the
    /// method's bias makes it: the shadow's band at the contact.
    pub peter_panning: f64,
    /// Light leak: false light far from an edge and from a contact, behind a caster.
    pub leak: f64,
    /// False light beyond the plan's shadow distance; whatever else would explain it.
    pub beyond_range: f64,
    /// False light and false shadow within a filter's reach of a true edge, R + 1 texels as large as they
    /// look on the receiver and 1 pixel: the map's resolution. An edge that something hides, or
    /// outside the picture, explains nothing.
    pub edge: f64,
    /// Root of the mean squared error of the shadow term. A term is clamped to 0..1 first; one that is
    /// not a number is off by 1.
    pub rmse: f64,
    /// The error of the shadow term, taken so, that 99 of 100 samples do not exceed.
    pub p99: f64,
    /// Median distance from each true shadow edge to the nearest rendered one, and from each rendered
    /// one to the nearest true one; pixels. An edge lies between two neighbouring pixels that see one
    /// surface, one lit and one in shadow, or on a pixel that is ½. Where a light has edges in one of
    /// the two pictures alone, each is as far off as the picture's diagonal is long.
    pub edge_p50: Option<f64>,
    /// The distance that 95 of 100 do not exceed; pixels.
    pub edge_p95: Option<f64>,
    /// The greatest distance; pixels.
    pub edge_max: Option<f64>,
    /// How many pixels a shadow texel covers across, d / d_i (see [`aliasing`]): what 95 of 100 samples
    /// that face their light and lie in its map do not exceed.
    pub alias_p95: Option<f64>,
    /// Share of these where a texel covers more than one pixel.
    pub alias_over_1: Option<f64>,
    /// 95th percentile of the perspective part of d / d_i.
    pub alias_perspective_p95: Option<f64>,
    /// 95th percentile of the projection part of d / d_i.
    pub alias_projection_p95: Option<f64>,
    /// Share of the samples that flip from one frame to the next under a small motion of the camera,
    /// less those that flip in truth: see [`shimmer`]. [`figures`] leaves it none.
    pub shimmer: Option<f64>,
    /// Mean FLIP of the shaded picture against the picture with true shadows; 0 alike to 1: see
    /// [`flip`]. [`figures`] leaves it none.
    pub flip: Option<f64>,
    /// Samples that are not a number, infinite, or outside 0..1; of all pixels, compared or not.
    pub bad_pixels: u64,
}

/// Whether the rasteriser saw what the ray saw.
fn is_compared(sight: &Sight, raster: &[Option<(u32, u32)>], pixel: usize) -> bool {
    let seen = sight.seen()[pixel].map(|seen| (seen.object, seen.triangle));
    seen.is_some() && seen == raster[pixel]
}

/// Data of all lights.
#[derive(Default)]
struct Pool {
    /// All that is merely counted; shares are still numbers of samples.
    counts: Figures,
    errors: Vec<f64>,
    distances: Vec<f64>,
    aliases: Vec<Alias>,
}

impl Pool {
    fn add(&mut self, surface: &Surface, sample: &Sample<'_>, is_compared: impl Fn(usize) -> bool) {
        self.counts.bad_pixels += bad_pixels(sample.rendered);
        let reached = sample.truth.iter().filter(|truth| truth.is_some()).count();
        // Compared samples alone, from here on.
        let truth: Vec<_> = sample
            .truth
            .iter()
            .enumerate()
            .map(|(pixel, truth)| truth.filter(|_| is_compared(pixel)))
            .collect();
        let pairs = truth.iter().zip(sample.rendered);
        let back_facing = surface.back_facing(sample.light);
        let known = pairs
            .zip(&back_facing)
            .filter_map(|((truth, rendered), away)| {
                let error = error((*truth)?, *rendered);
                // No error is seen where no light reaches the eye.
                Some(if *away { 0.0 } else { error })
            });
        let before = self.errors.len();
        self.errors.extend(known);
        let compared = self.errors.len() - before;
        self.counts.compared += compared as u64;
        self.counts.left_out += (reached - compared) as u64;

        let texels = match sample.plan {
            Some(plan) => texels(surface, sample.light, plan),
            None => vec![None; truth.len()],
        };
        let seen = texels.iter().zip(&truth).filter(|(_, t)| t.is_some());
        self.aliases
            .extend(seen.filter_map(|(texel, _)| texel.as_ref()?.alias));
        let dark = truth.iter().zip(&back_facing);
        let dark = dark.filter(|(truth, away)| !**away && truth.is_some_and(|term| term < 0.5));
        self.counts.in_shadow += dark.count() as f64;
        self.add_edges_and_causes(surface, sample, &truth, (&texels, &back_facing));
    }

    fn add_edges_and_causes(
        &mut self,
        surface: &Surface,
        sample: &Sample<'_>,
        truth: &[Option<f32>],
        (texels, back_facing): (&[Option<alias::Texel>], &[bool]),
    ) {
        let true_sides: Vec<Side> = truth.iter().map(|truth| truth.and_then(side)).collect();
        let pairs = truth.iter().zip(sample.rendered);
        let sides = pairs.map(|(truth, rendered)| truth.and_then(|_| side(*rendered)));
        let sides: Vec<Side> = sides.collect();
        let (true_edges, edges) = rayon::join(
            || Edges::new(surface, &true_sides, back_facing),
            || Edges::new(surface, &sides, back_facing),
        );
        let diagonal = (surface.width as f64).hypot(surface.height as f64);
        self.distances
            .extend(true_edges.distances(&edges, diagonal));
        self.distances
            .extend(edges.distances(&true_edges, diagonal));
        let case = Case {
            surface,
            truth: &true_sides,
            rendered: &sides,
            gaps: sample.gaps,
            back_facing,
            texels,
            true_edges: &true_edges,
            plan: sample.plan,
        };
        for (pixel, cause) in case.causes().into_iter().enumerate() {
            self.count(cause, true_sides[pixel]);
        }
    }

    fn count(&mut self, cause: Option<Cause>, truth: Side) {
        let counts = &mut self.counts;
        let share = match cause {
            None => return,
            Some(Cause::Acne) => &mut counts.acne,
            Some(Cause::BackFacing) => {
                counts.back_facing += 1.0;
                return;
            }
            Some(Cause::PeterPanning) => &mut counts.peter_panning,
            Some(Cause::Leak) => &mut counts.leak,
            Some(Cause::BeyondRange) => &mut counts.beyond_range,
            Some(Cause::Edge) => &mut counts.edge,
        };
        *share += 1.0;
        match truth {
            Some(std::cmp::Ordering::Less) => counts.false_lit += 1.0,
            _ => counts.false_shadow += 1.0,
        }
    }

    fn figures(mut self) -> Figures {
        let compared = self.counts.compared;
        let share = |count: f64| count / compared.max(1) as f64;
        let squares: f64 = self.errors.iter().map(|error| error * error).sum();
        let wrong = self.counts.false_lit + self.counts.false_shadow;
        let of_shadow = |count: f64| {
            let dark = self.counts.in_shadow;
            (dark > 0.0).then(|| count / dark)
        };
        let part = |part: fn(&Alias) -> f64| self.aliases.iter().map(part).collect::<Vec<_>>();
        let over_1 = self.aliases.iter().filter(|alias| alias.ratio() > 1.0);
        let over_1 = over_1.count() as f64 / self.aliases.len() as f64;
        Figures {
            false_lit: share(self.counts.false_lit),
            false_shadow: share(self.counts.false_shadow),
            in_shadow: share(self.counts.in_shadow),
            false_lit_of_shadow: of_shadow(self.counts.false_lit),
            error_of_shadow: of_shadow(wrong),
            acne: share(self.counts.acne),
            back_facing: share(self.counts.back_facing),
            peter_panning: share(self.counts.peter_panning),
            leak: share(self.counts.leak),
            beyond_range: share(self.counts.beyond_range),
            edge: share(self.counts.edge),
            rmse: share(squares).sqrt(),
            p99: percentile(&mut self.errors, 99).unwrap_or_default(),
            edge_p50: percentile(&mut self.distances, 50),
            edge_p95: percentile(&mut self.distances, 95),
            edge_max: percentile(&mut self.distances, 100),
            alias_p95: percentile(&mut part(Alias::ratio), 95),
            alias_over_1: (!self.aliases.is_empty()).then_some(over_1),
            alias_perspective_p95: percentile(&mut part(|alias| alias.perspective), 95),
            alias_projection_p95: percentile(&mut part(|alias| alias.projection), 95),
            ..self.counts
        }
    }
}

/// How many rendered terms are not a number, infinite, or outside 0..1.
pub(crate) fn bad_pixels(rendered: &[f32]) -> u64 {
    let bad = |term: &&f32| !(0.0..=1.0).contains(*term);
    rendered.iter().filter(bad).count() as u64
}

/// By how much a rendered term is off; 0 to 1.
fn error(truth: f32, rendered: f32) -> f64 {
    if rendered.is_nan() {
        return 1.0;
    }
    f64::from(rendered.clamp(0.0, 1.0) - truth).abs()
}

/// The least value that so many of 100 (1 to 100) do not exceed; none of no values.
fn percentile(values: &mut [f64], of_100: usize) -> Option<f64> {
    let rank = (values.len() * of_100).div_ceil(100);
    let index = rank.checked_sub(1)?;
    let (_, value, _) = values.select_nth_unstable_by(index, f64::total_cmp);
    Some(*value)
}

//! How much the shadow term flickers while the camera moves.

use std::cmp::Ordering;

use glam::DVec3;
use rayon::prelude::*;
use umbrage_render::Scene;
use umbrage_shadow::Light;

use super::{
    FigureError,
    edges::{Side, side},
    is_compared,
    surface::{Facet, Surface},
};
use crate::truth::Sight;

/// One picture of a sequence.
#[derive(Clone, Debug)]
pub struct Frame<'a> {
    /// The scene, which the frames share but for the camera.
    pub scene: &'a Scene,
    /// Points that the pixels see.
    pub sight: &'a Sight,
    /// Object and triangle that the rasteriser drew in each pixel.
    pub raster: &'a [Option<(u32, u32)>],
    /// The shadow terms of each light; as many in every frame.
    pub lights: Vec<Terms<'a>>,
}

/// One light's shadow term in a frame.
#[derive(Clone, Copy, Debug)]
pub struct Terms<'a> {
    /// The light.
    pub light: &'a Light,
    /// Terms in truth.
    pub truth: &'a [Option<f32>],
    /// Terms as rendered.
    pub rendered: &'a [f32],
}

/// The share of samples whose side of ½ flips from one frame to the next as rendered, less the share
/// that flips in truth; 0 to 1, the mean over pairs of frames. None where no sample is known in two
/// frames.
///
/// It is the surface that flips, not the pixel: the point of a compared sample that faces its light is looked for in the next
/// frame. It is known there if it lies between four pixels that are compared, see the surface that it is on,
/// and agree on a side, rendered and in truth; it has flipped if their side is not its own. So an
/// edge that stays in its place on the surface does not count, however the camera moves, and one that
/// moves by less than about a pixel does not either. A corner that stays and reaches in between four
/// pixels does: that share is small, and a quarter of it in twice the resolution.
///
/// # Errors
/// Pictures of different sizes within a frame, frames with different numbers of lights, a sight of
/// another scene.
pub fn shimmer(frames: &[Frame<'_>]) -> Result<Option<f64>, FigureError> {
    let lights = frames.first().map_or(0, |frame| frame.lights.len());
    let mut shares = Vec::new();
    let mut before: Option<Still<'_>> = None;
    for (index, frame) in frames.iter().enumerate() {
        let still = Still::new(frame, index, lights)?;
        if let Some(before) = before {
            shares.extend(before.flips_until(&still));
        }
        before = Some(still);
    }
    let sum: f64 = shares.iter().sum();
    Ok((!shares.is_empty()).then(|| sum / shares.len() as f64))
}

/// A frame, prepared.
struct Still<'a> {
    surface: Surface,
    /// Where no light of each reaches the eye.
    back_facing: Vec<Vec<bool>>,
    frame: &'a Frame<'a>,
}

/// How many samples are known in two frames, and how many of them flip.
#[derive(Clone, Copy, Default)]
struct Flips {
    known: u64,
    rendered: u64,
    truth: u64,
}

impl<'a> Still<'a> {
    fn new(frame: &'a Frame<'a>, index: usize, lights: usize) -> Result<Self, FigureError> {
        let (found, pixels) = (frame.lights.len(), frame.sight.seen().len());
        if found != lights {
            return Err(FigureError::Lights {
                frame: index,
                found,
                expected: lights,
            });
        }
        let check = |what: &str, found: usize| {
            FigureError::check(|| format!("{what} of frame {index}"), found, pixels)
        };
        check("the rasteriser's picture", frame.raster.len())?;
        for terms in &frame.lights {
            check("the truth", terms.truth.len())?;
            check("the rendered term", terms.rendered.len())?;
        }
        let surface = Surface::new(frame.scene, frame.sight)?;
        let lights = frame.lights.iter();
        Ok(Self {
            back_facing: lights
                .map(|terms| surface.back_facing(terms.light))
                .collect(),
            surface,
            frame,
        })
    }

    /// The share that flips until the next frame; none where no sample is known in both.
    fn flips_until(&self, next: &Still<'_>) -> Option<f64> {
        // Of two large numbers, before anything is rounded.
        let moved = self.surface.view.position - next.surface.view.position;
        let pixels = self.surface.facets.par_iter().enumerate();
        let flips = pixels
            .filter_map(|(pixel, facet)| {
                let (facet, around) = next.find(facet.as_ref()?, moved)?;
                Some(self.flips_of(pixel, next, &facet, around))
            })
            .reduce(Flips::default, Flips::and);
        let excess = flips.rendered.saturating_sub(flips.truth);
        (flips.known > 0).then(|| excess as f64 / flips.known as f64)
    }

    /// A facet of another frame as this frame has it, and the four pixels that it lies between; none
    /// outside the picture. `moved` takes the other frame's positions to this one's.
    fn find(&self, facet: &Facet, moved: DVec3) -> Option<(Facet, [usize; 4])> {
        let position = facet.position + moved;
        let at = self.surface.picture.place(position)? - 0.5;
        let [x, y] = at.floor().to_array();
        let (width, height) = (self.surface.width, self.surface.height);
        let inside = x >= 0.0 && y >= 0.0 && x as usize + 1 < width && y as usize + 1 < height;
        let first = y as usize * width + x as usize;
        let around = [first, first + 1, first + width, first + width + 1];
        inside.then_some((Facet { position, ..*facet }, around))
    }

    fn flips_of(&self, pixel: usize, next: &Still<'_>, facet: &Facet, around: [usize; 4]) -> Flips {
        let sees_it = |pixel: &usize| {
            let there = next.surface.facets[*pixel].as_ref();
            there.is_some_and(|there| there.continues(facet))
        };
        if !around.iter().all(sees_it) {
            return Flips::default();
        }
        let lights = 0..self.frame.lights.len();
        let flips = lights.filter_map(|light| {
            let now = self.sides(pixel, light)?;
            let then = next.sides(around[0], light)?;
            let mut others = around[1..].iter();
            let agree = others.all(|other| next.sides(*other, light) == Some(then));
            agree.then(|| Flips {
                known: 1,
                rendered: u64::from(now[0] != then[0]),
                truth: u64::from(now[1] != then[1]),
            })
        });
        flips.fold(Flips::default(), Flips::and)
    }

    /// On which side a compared sample that faces its light is, rendered and in truth; none where it is on neither.
    fn sides(&self, pixel: usize, light: usize) -> Option<[Ordering; 2]> {
        let Frame { sight, raster, .. } = self.frame;
        let Terms {
            truth, rendered, ..
        } = self.frame.lights[light];
        let is_seen = is_compared(sight, raster, pixel) && !self.back_facing[light][pixel];
        let truth = truth[pixel].filter(|_| is_seen)?;
        let decided = |side: Side| side.filter(|side| side.is_ne());
        Some([decided(side(rendered[pixel]))?, decided(side(truth))?])
    }
}

impl Flips {
    fn and(self, other: Self) -> Self {
        Self {
            known: self.known + other.known,
            rendered: self.rendered + other.rendered,
            truth: self.truth + other.truth,
        }
    }
}

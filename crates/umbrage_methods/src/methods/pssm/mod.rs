//! Parallel-split shadow maps (Zhang et al. 2006; Engel 2007 called them cascaded): the view's depths are split,
//! and each split has a map of its own. Its shader half is `methods/pssm.wesl` and the folder beside it.
//!
//! # How it works
//! The range of view depths where receivers are seen, no farther than `shadow_distance`, is split by the
//! practical scheme (see [`split_depths`](umbrage_shadow::split_depths)). Each split's map holds the receivers seen
//! in it; a split without any has no map, no pass, and no texels; nor has one whose receivers all lie beside all casters,
//! seen from a sun. Into it are drawn the casters between its
//! receivers and the light, with the near plane at the nearest of them. Of a spot light the maps are crops of
//! the light's own perspective, before its division.
//!
//! Air is seen from the near plane on. To a perspective view, the first split holds what lies before all surfaces, which needs
//! hardly a larger map: splits are as fine as without air.
//!
//! An orthographic view is split evenly, whatever `lambda` is: its pixels are as large at all depths. `stable` splits of it
//! have one grid of texels, so that no shadow tells where they meet; `shadow_distance` counts from where its camera stands.
//!
//! All maps are tiles of one atlas. What a map is read for ends a filter's reach before the tile's edge, and
//! fetches are clamped to the tile besides.
//!
//! Two ways to fit, the axis `fit`:
//! - `stable`: a map is a square around the sphere of all that the camera may see in the split, as far away as what it does see
//!   there, wherever it looks. Its corner stands on a grid of texels that is fixed in the world, in f64. So
//!   a texel covers the same part of the world from frame to frame, and edges do not crawl. Where all casters
//!   lie in less than the sphere, the square is theirs. Sizes seldom change: distances and squares are rounded up to an eighth of an
//!   octave, and the range's ends outwards to a quarter of one. Of a spot light, the square around the receivers is
//!   rounded up to a power of √2, on a grid that is fixed to the light.
//! - `tight`: the rectangle of the receivers seen in the split, as far as casters lie in it, and the range as it is. Texels are finer, and
//!   follow the view from frame to frame.
//!
//! Splits divide the view depths that receivers' boxes say may be seen. They say too much where something near hides a long street:
//! with the axis `range` at `depths`, the range ends where pixels see something: a first plan reduces the camera's depth to
//! two numbers and asks for them, and the second one splits what lies between (after Lauritzen, Salvi and Lefohn 2011,
//! "Sample distribution shadow maps", of which this is the range alone). It costs a pass over the camera's depth for each
//! light, and a wait within the frame where the engine waits; and splits move with what is seen, by quarters of an octave where
//! the fit is `stable`. Where air is a receiver, boxes bound the range.
//!
//! # Settings and axes
//! `splits`, `lambda`, `shadow_distance` (metres), `resolution` (texels along a tile), `depth_bias` (texels of the
//! split's own map, towards the light), `band` (of a split's length). What the shader does: `receiver_bias` as for
//! [`super::basic`]; `transition` says what happens in the band before a split's end
//! (nothing, a blend with the next split's map, or a choice between the two by noise); `lookup` how the place in
//! a split's map is found. All lookups give the same shadow:
//!
//! - `packed`: the light's matrix once, and each split's crop, an offset and a scale, from the uniform block.
//! - `storage`: each split's whole matrix from a storage buffer.
//! - `matrix_texture`: the same from a texture, row by row; five fetches more, the fifth for bias and slope.
//! - `masks`: the crops of four splits as matrices, multiplied with a mask; nothing is found by number.
//! - `branches`: a texture for each of four splits, found by a chain of branches.
//! - `weights`: the same; all four are filtered, and one is weighted.
//! - `channels`: four splits in the channels of one `rgba32float` texture; texels are loaded and compared by hand.
//!
//! With `taper`, the filter is two texels narrower from split to split, one texel at the least: texels grow from split
//! to split, and a filter of one width in texels would blur ever more of the world. The plan's
//! [regions](ShadowPlan::regions) tell where a permutation without bands, of one width, does the same.
//!
//! # Cost
//! A pass for each split, and ((W + 1) / 2)² fetches a pixel for width W; twice as many where `transition` is
//! `blend` and the pixel is in a band. `weights` makes four times as many, `matrix_texture` five more, and
//! `channels` (W + 1)², of 16 bytes each, where a depth map's texel has four. With `taper` W is that of the pixel's own
//! split, which is a loop of so many turns where one shader is for all splits.
//!
//! A compiler's figures for the shadow term under a directional light with W = 3 (RDNA 2, Mesa's RADV; `umbrage cost
//! permutations/demo.ron`), and how many four-component uniforms it reads (the reflection in `umbrage prebuild
//! permutations/demo.ron`; `storage` has five a split in its buffer besides, `matrix_texture` five texels). Each needs one
//! interpolator, the position. Beside it what the idea's author counted of his own on arbfp1, with one fetch a map:
//!
//! | lookup | instructions | registers | fetches | uniforms | then: instructions | uniforms | interpolators |
//! | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |
//! | `branches` | 684 | 24 | 4 | 29 | 25 | 18 | 5 |
//! | `weights` | 677 | 32 | 16 | 29 | 15 | | |
//! | `matrix_texture` | 257 | 32 | 9 | 9 | 19 | 2 | 1 |
//! | `packed` | 264 | 24 | 4 | 25 | | | |
//! | `masks` | 289 | 24 | 4 | 17 | | | |
//! | `channels` | 400 | 32 | 16 | 25 | | | |
//! | `storage` | 255 | 24 | 4 | 9 | | | |
//!
//! Without filter and receiver's plane (`cargo bench --profile dev -p umbrage_bench --bench methods`), RADV expects of
//! `storage` and `matrix_texture` 0.97 of the inverse throughput of `branches`, of `packed` 1.06, and of one map without any
//! splits still 0.58: it counts one way through the branches, as if a wave's pixels were all in one split. On a CPU, which
//! takes all ways, `packed` and `matrix_texture` take 0.39 and 0.40 of the time.
//!
//! # Limits
//! Point lights are not supported: a cube map has no splits. Flat light is followed as by [`super::basic`], with
//! its limits. Between splits, the size of texels jumps.

mod fit;
mod lookup;
mod range;
mod regions;

use umbrage_shadow::{
    Atlas, Choice, Frame, Light, LightKind, MAX_SPLITS, Part, PlanError, Setting, ShadowMethod,
    ShadowPlan, Support,
};

use lookup::Lookup;
use range::Range;

pub use range::seen;

/// The method `pssm`.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pssm;

const NO_CUBES: &str = "a cube map has no splits; choose another method for point lights";

const SETTINGS: [Setting; 6] = [
    Setting {
        name: "splits",
        doc: "how many splits the range of view depths has",
        min: 1.0,
        max: MAX_SPLITS as f64,
        default: 4.0,
        whole: true,
    },
    Setting {
        name: "lambda",
        doc: "from splits of equal lengths (0) to splits of equal ratios (1); an orthographic view's have equal lengths",
        min: 0.0,
        max: 1.0,
        default: 1.0,
        whole: false,
    },
    Setting {
        name: "shadow_distance",
        doc: "the view depth beyond which there is no shadow, metres; 0 for all that is seen",
        min: 0.0,
        max: 1e9,
        default: 0.0,
        whole: false,
    },
    Setting {
        name: "resolution",
        doc: "texels along each side of a split's map",
        min: 64.0,
        max: Atlas::MOST_TEXELS as f64,
        default: 1024.0,
        whole: true,
    },
    Setting {
        name: "depth_bias",
        doc: "how far a receiver is moved towards the light before it is compared, in its map's texels",
        min: 0.0,
        max: 64.0,
        default: 1.5,
        whole: false,
    },
    Setting {
        name: "band",
        doc: "the share of a split's length in which it passes into the next",
        min: 0.01,
        max: 1.0,
        default: 0.1,
        whole: false,
    },
];

impl Part for Pssm {
    fn name(&self) -> &str {
        "pssm"
    }

    fn settings(&self) -> &[Setting] {
        &SETTINGS
    }

    fn axes(&self) -> &[&str] {
        &[
            Choice::DEPTH,
            Choice::FILTER,
            "fit",
            "lookup",
            "range",
            "receiver_bias",
            "taper",
            "transition",
        ]
    }
}

impl ShadowMethod for Pssm {
    fn supports(&self, light: &Light) -> Support {
        match light.kind {
            LightKind::Point { .. } => Support::No(NO_CUBES.to_owned()),
            _ => Support::Yes,
        }
    }

    fn plan(&self, frame: &Frame<'_>) -> Result<ShadowPlan, PlanError> {
        let job = fit::Job::new(frame)?;
        if job.range == Range::Unknown {
            return range::question(frame);
        }
        let splits = match frame.light.kind {
            LightKind::Directional { direction } => job.directional(direction.normalize())?,
            LightKind::Spot {
                position,
                direction,
                outer_angle,
                range,
                ..
            } => {
                let position = position - job.bounds.origin;
                job.spot(position, direction.normalize(), outer_angle, range)?
            }
            LightKind::Point { .. } => {
                return Err(PlanError::Unsupported {
                    method: self.name().to_owned(),
                    reason: NO_CUBES.to_owned(),
                });
            }
        };
        let mut plan = lookup::plan(&job, &splits)?;
        if job.range != Range::Boxes {
            range::reduce(frame, &mut plan)?;
        }
        Ok(plan)
    }
}

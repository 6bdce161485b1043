//! The truth of a scene's shadows, and how far a shadow method is from it.
//!
//! # The model
//! A shadow method answers one question approximately: does the light reach this point? This crate
//! answers it by rays in f64, from the same [`Scene`](umbrage_render::Scene) that the renderer draws:
//!
//! 1. **Sight.** Through the centre of each pixel goes a ray from the camera. The nearest triangle
//!    between the camera's near and far distance is what the pixel sees: an object, one of its
//!    triangles, and a point on it. Both sides of a triangle are seen.
//! 2. **Shadow.** From that point goes a ray to the light. The point is in shadow where the ray meets a
//!    triangle of an object that casts strictly between the two: the point and the light lie on different sides of
//!    that triangle. A triangle that the point or the light lies on casts no shadow on the point.
//!
//! Where a material has a cut-off, what is less opaque than that is no surface, for either ray; the
//! texture is read in full resolution. A light that is no point gets many rays, spread evenly over the
//! angle that it fills, and the shadow term is the share of them that arrive.
//!
//! There is nothing to see, or no light to be kept off (beyond the range of a light, outside the cone
//! of a spot light, on a surface that the light runs along), where the shadow term is `None`. In pictures that is 1, as the renderer has it.
//! Whether a light has a shadow method makes no difference to the truth, and neither does a cookie.
//!
//! ```
//! use umbrage_measure::truth::Tracer;
//! use umbrage_render::Scene;
//!
//! let scene = Scene::load("../../examples/scenes/bunny_sun.ron")?;
//! let tracer = Tracer::new(&scene)?;
//! let sight = tracer.look(64, 36, &|| ())?;
//! let terms = tracer.shadow(&sight, 0, umbrage_measure::truth::Source::Sharp, &|| ())?;
//! let dark = terms.iter().filter(|term| **term == Some(0.0)).count();
//! assert!(dark > 0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Hard cases
//! [`cases::all`] makes scenes that catch shadow methods out; `limits.ron` beside this crate's sources says what
//! each demands and why, and [`Limits::judge`](cases::Limits::judge) holds figures against it.
//! Held against them are *variants*: a method as it is, or with other values for its axes and settings, which the
//! same table lists by names. A variant that cannot meet a limit is listed there with the reason; a listed exception
//! that is no longer needed is a fault as well. No variant may have a bad pixel in any case.
//!
//! | cases | what is hard |
//! | --- | --- |
//! | `depth-range`, `-spot` | 1 to 900 m in a view from 0.1 to 1000 m; a spot light's casters from 2 cm, receivers to 90 m |
//! | `split-seams`, `-fence` | a receiver with shadow edges across every border that splits the view |
//! | `duelling-frusta-along`, `-against`, `-lamp` | light along the view, against it, and from its middle |
//! | `overhead`, `-down`, `-spot` | light straight down, seen aslant and straight down; straight down and up |
//! | `grazing-80`, `-85`, `-89` | light at so many degrees to the ground's normal |
//! | `far-away-origin`, `-1e5`, `-1e6`, `tiny`, `huge` | one yard under three lights, 100 and 1000 km out, at 1e-3 and 1e4 of its size |
//! | `open-mesh`, `-leaves`, `-mirrored` | no back faces, no thickness, transforms that mirror |
//! | `contact`, `-lamp` | a thin wall, a ball and a cone's tip on the ground |
//! | `behind`, `-light`, `-spot` | casters behind the viewer, and far out towards the light |
//! | `exponent`, `-overlap`, `-overlap-spot`, `-contact`, `-contact-spot` | occluders 80 m before a receiver, two that overlap, and ones that touch it in a map that deep |
//! | `steep-blocks-3`, `-5`, `-7`, `-15`, `-spot-3` to `-spot-15` | planes, nearly planes, steps and slivers under few texels, by filter width |
//! | `empty-casters`, `-split`, `-giant`, `-1x1`, `-degenerate`, `-inside`, `-head` | no casters, none in a split, one of 40 km, one texel, triangles without area, the viewer inside a caster |
//! | `wall-lamp`, `-near`, `-wash` | a lamp 5 and 2 cm before a wall, and a spot light that washes it: all angles to its normal, to 89.8° |
//! | `motion`, `-lamps` | 64 frames, each less than a texel and a pixel from the last |
//! | `orthographic-seams`, `-grazing`, `-motion` | the same of three families under a camera of parallel rays |
//!
//! Each scene is traced in its tests: there is light and shadow in healthy shares, and what its name says
//! (an angle, a ratio, a border) holds exactly.
//!
//! # What keeps it true
//! - **No bias.** The triangle that a point lies on is left out by its number. Its neighbours are not, but
//!   a point on a shared edge lies on them too, as far as f64 can tell: so a hit that is no farther away
//!   than the rounding of the numbers that it was computed from is none. That bound follows the numbers:
//!   it shrinks and grows with the scene.
//! - **A light in a surface** (a lamp in a ceiling, a spot light's apex on a wall, a lamp on a box's edge) shines to
//!   both sides, as far as nothing else is in its way: each point is lit as if the light were moved ever so little
//!   towards it. The light lies on a triangle if its distance from the triangle's plane is within rounding: of f64
//!   where the light stands in the world, and a step of f32 of the corners as their mesh has them, so that a lamp at
//!   0.4 m lies on a box whose corner is the f32 next to 0.4. This depends on the light alone, not on the ray to it:
//!   so all points behind a surface agree. Of a sphere of light that a surface cuts, the part on the point's side is
//!   seen. A renderer means the same where its maps begin behind the surface that the light lies on; but its maps
//!   leave out all casters nearer than a share of the light's range, which here shade (see `umbrage_methods::basic`).
//! - **No gaps.** Of two triangles that share an edge, a ray that passes through the edge meets at least one
//!   (Woop, Benthin and Wald 2013: "Watertight Ray/Triangle Intersection").
//! - **No place.** Positions are relative to the camera, and f64 throughout: a scene a thousand kilometres
//!   out is traced as at the origin.
//! - **No chance.** The same scene gives the same numbers whatever the number of threads; the rays of a
//!   light with an extent are placed by a hash of the pixel's number.
//!
//! # The figures
//! [`figures`] holds rendered shadow terms against true ones. A *sample* is a pixel in one light. It is
//! *compared* where something is seen, the light reaches it, and the rasteriser drew the very triangle that
//! the ray met; where it drew another one, it is *left out*, and counted. All lights are pooled. Lit is above
//! ½, in shadow below. [`Figures`](figures::Figures) says each to the letter.
//!
//! | figure | what | unit |
//! | --- | --- | --- |
//! | `compared`, `left_out` | how many samples there are | samples |
//! | `false_lit`, `false_shadow` | lit but should not be, and the reverse, on what faces the light | share of the compared |
//! | `in_shadow` | in shadow in truth, on what faces the light | share |
//! | `false_lit_of_shadow`, `error_of_shadow` | `false_lit`, and both, over `in_shadow` | share of the shadow |
//! | `back_facing` | wrong on what is turned away from the light: none of it reaches the eye from there, so nobody sees it | share |
//! | `beyond_range` | false light farther out than the method's shadow distance | share |
//! | `peter_panning` | else, peter-panning: false light where what should shade is as near as a bias or the filter reaches, and all that goes on from there without a break | share |
//! | `edge` | else, false light or shadow where the filter reaches a true edge | share |
//! | `leak`, `acne` | else, false light (a light leak), and false shadow | share |
//! | `rmse`, `p99` | the term's error: root of the mean square, and what 99 of 100 do not exceed | of the term, 0 to 1 |
//! | `edge_p50`, `edge_p95`, `edge_max` | from each true shadow edge to the nearest rendered one, and back | pixels |
//! | `alias_p95`, `alias_over_1` | d / d_i, how many pixels a texel covers across: a percentile, and the share above 1 | pixels a texel; share of the samples that face their light |
//! | `alias_perspective_p95`, `alias_projection_p95` | its two factors: what the map's projection makes of it, and what the receiver's slope does | pixels a texel; 1 |
//! | `shimmer` | samples that flip from frame to frame on the moving camera's surfaces, less those that flip in truth | share of the samples known in both |
//! | `flip` | mean FLIP of the shaded picture against the one with true shadows | 0 alike to 1 |
//! | `bad_pixels` | not a number, infinite, or outside 0..1 | samples |
//!
//! Every wrong sample that is seen has exactly one cause: `beyond_range`, `peter_panning`, `edge`, `leak` and `acne`
//! add up to `false_lit` and `false_shadow`. Errors on back-facing sides are in none of the others, nor in `rmse`, `p99`, `shimmer`
//! and the edges. How far a bias and a filter reach comes from the plan (the filter's
//! radius, the passes' matrices) and from the receiver's slope; see [`figures::aliasing`].
//!
//! ```
//! use umbrage_measure::{figures::{Sample, figures}, truth::{Source, Tracer}};
//! use umbrage_render::Scene;
//!
//! let scene = Scene::load("../../examples/scenes/bunny_sun.ron")?;
//! let tracer = Tracer::new(&scene)?;
//! let sight = tracer.look(64, 36, &|| ())?;
//! let truth = tracer.shadow(&sight, 0, Source::Sharp, &|| ())?;
//! let gaps = tracer.gaps(&sight, 0, &|| ())?;
//! // What a renderer makes of it: here, light everywhere, and the rays' own triangles.
//! let rendered = vec![1.0; 64 * 36];
//! let seen = sight.seen().iter();
//! let raster: Vec<_> = seen.map(|s| s.map(|s| (s.object, s.triangle))).collect();
//! let light = &scene.lights[0].light;
//! let sample = Sample { light, truth: &truth, gaps: &gaps, rendered: &rendered, plan: None };
//! let found = figures(&scene, &sight, &raster, &[sample])?;
//! assert!(found.false_lit > 0.0 && found.false_shadow == 0.0);
//! assert_eq!(found.edge_p50, Some(64_f64.hypot(36.0)));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Comparing methods
//! [`study::compare`] draws scenes with configurations of methods and puts errors beside costs, the time
//! always as a ratio to the plainest shadow map's, drawn right before or after ([`report::Ratio`]); [`report::write`] makes a page of it.
//! [`study::stress`] draws the hard cases and holds them against their limits. A method takes part by being
//! registered: without a line of its own in `configs.ron` it is compared with its defaults and with each value
//! of its axes; without a variant of its own in `limits.ron` it is stressed with its defaults.
//!
//! # Cost
//! The triangles lie in a tree of boxes (`parry3d`), so that a ray costs about the logarithm of their
//! number; the rows of a picture are shared among all threads. A triangle takes about 400
//! bytes while the tree is built, and less after: `cargo bench -p umbrage_bench --bench truth`. Figures cost
//! less than the rays: their time is that of a few exact distance transforms (`imageproc`) of pictures twice
//! as wide and high.

pub mod cases;
mod config;
mod error;
pub mod figures;
pub mod report;
pub mod study;
pub mod truth;

use config::Config;
use error::StudyError;

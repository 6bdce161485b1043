//! How large a shadow texel looks.

use glam::DVec2;
use rayon::prelude::*;
use umbrage_render::Scene;
use umbrage_shadow::{Light, Pass, ShadowPlan};

use super::{
    FigureError,
    surface::{Cells, Facet, Surface, stretch},
};
use crate::truth::{Sight, lamp::Lamp};

/// Where light comes in flatter than this cosine (87° to the normal), it is taken to come in so. A texel
/// covers 20 times its width there, and no finite number of them where the light only grazes: a filter
/// would explain every error. A surface lit so gets a twentieth of the light at the most.
const FLATTEST: f64 = 0.05;

/// How many pixels a shadow texel covers across, d / d_i, in its two parts (Stamminger and Drettakis
/// 2002, "Perspective shadow maps"). Both are 1 where nothing is to be gained.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Alias {
    /// The texel's width across the light's ray over the pixel's width across the line of sight, both
    /// at the receiver: d_s r_s / (d_i r_i), where d_s and d_i are their angles and r_s and r_i the
    /// distances. A method can choose it.
    pub perspective: f64,
    /// N · V / N · L, which the receiver's slope to the viewer V and the light L decides.
    pub projection: f64,
}

impl Alias {
    /// d / d_i: the pixels that a texel covers along the slope.
    pub fn ratio(&self) -> f64 {
        self.perspective * self.projection
    }
}

/// How many pixels a texel covers at each pixel of a picture, by rows from the top; none where
/// nothing is seen, the light comes from behind the surface, or no map of the plan holds the point.
///
/// The maps are the viewports of the plan's caster passes. Each is the projection that its matrix is,
/// so any will do: orthographic, a spot light's, a cube's faces, a warped one. Of those that hold a
/// point, the one counts that is [read at its view depth](umbrage_shadow::CasterPass::receivers); where
/// the plan does not tell, or several are, the one with the smallest texel there: what the plan could
/// give at best. A texel (a
/// pixel) is as wide as the square of its area: 1 / √|det| of the derivative of texels (pixels) by metres
/// along two directions perpendicular to the light's ray (the line of sight).
///
/// `plan` is of this very view: its matrices are relative to the [scene's](Scene::view).
///
/// # Errors
/// A sight of another scene, or a camera that cannot be used.
pub fn aliasing(
    scene: &Scene,
    sight: &Sight,
    light: &Light,
    plan: &ShadowPlan,
) -> Result<Vec<Option<Alias>>, FigureError> {
    let surface = Surface::new(scene, sight)?;
    let texels = texels(&surface, light, plan);
    Ok(texels.iter().map(|texel| texel.as_ref()?.alias).collect())
}

/// A texel where a receiver is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Texel {
    /// Its longest side across the light's ray; metres.
    pub(super) width: f64,
    /// By how much the receiver's slope stretches it; 1 to 1 / [`FLATTEST`].
    pub(super) slope: f64,
    /// How many pixels it covers on the receiver, along whichever direction they are most.
    pub(super) pixels: f64,
    /// None where the light comes from behind the surface.
    pub(super) alias: Option<Alias>,
}

/// The texel of the plan's maps that each pixel reads, as far as the plan tells.
pub(super) fn texels(surface: &Surface, light: &Light, plan: &ShadowPlan) -> Vec<Option<Texel>> {
    let lamp = Lamp::new(&light.kind, surface.view.position);
    let maps: Vec<_> = plan.passes.iter().filter_map(map).collect();
    let texel = |facet: &Option<Facet>| {
        let facet = facet.as_ref()?;
        let depth = facet.position.dot(surface.view.forward());
        let holding = maps
            .iter()
            .filter(|map| map.cells.place(facet.position).is_some());
        let (read, others): (Vec<_>, Vec<_>) = holding.partition(|map| map.is_read_at(depth));
        // Between two ranges, or beyond all, what the shader reads is not known.
        let maps = if read.is_empty() { others } else { read };
        Texel::new(facet, &lamp, &maps, &surface.picture)
    };
    surface.facets.par_iter().map(texel).collect()
}

/// A map that a pass draws.
struct Map {
    cells: Cells,
    /// The view depths that it is read for; metres.
    receivers: Option<[f64; 2]>,
}

impl Map {
    /// Whether a receiver at a view depth reads it for sure.
    fn is_read_at(&self, depth: f64) -> bool {
        let range = self.receivers.as_ref();
        range.is_none_or(|[near, far]| (*near..=*far).contains(&depth))
    }
}

fn map(pass: &Pass) -> Option<Map> {
    let Pass::Casters(pass) = pass else {
        return None;
    };
    let size = [pass.viewport.width, pass.viewport.height].map(f64::from);
    Some(Map {
        cells: Cells::new(pass.view_proj.as_dmat4(), DVec2::from(size)),
        receivers: pass.receivers,
    })
}

impl Texel {
    /// The finest texel of `maps`, all of which hold the facet's middle.
    fn new(facet: &Facet, lamp: &Lamp, maps: &[&Map], picture: &Cells) -> Option<Self> {
        let point = facet.position;
        let to_light = lamp.middle(point).direction.try_normalize()?;
        let texel = maps
            .iter()
            .map(|map| map.cells.across(point, to_light))
            .filter(|texel| texel.width().is_finite())
            .min_by(|a, b| a.width().total_cmp(&b.width()))?;
        let metres = texel.cells.inverse();
        let facing = facet.normal.dot(to_light);
        let toward = facing.abs().max(FLATTEST).copysign(facing);
        // Steps beside the ray, carried along the ray back onto the receiver's plane.
        let on_receiver = texel
            .directions
            .map(|aside| aside - to_light * (facet.normal.dot(aside) / toward));
        let alias = Alias {
            perspective: texel.width() / facet.pixel,
            projection: facet.normal.dot(facet.to_viewer) / facing,
        };
        Some(Self {
            width: stretch(metres),
            slope: toward.abs().recip(),
            pixels: stretch(picture.derivative(point, on_receiver) * metres),
            alias: (facing > 0.0).then_some(alias),
        })
    }
}

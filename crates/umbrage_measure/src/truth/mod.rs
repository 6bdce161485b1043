//! Shadows by rays in f64. The crate's page tells the model.

mod content;
mod error;
pub(crate) mod lamp;
mod opacity;
mod ray;
mod record;
#[cfg(test)]
pub(crate) mod tests;
mod triangles;

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use umbrage_render::Scene;
use umbrage_shadow::{Field, Light, Projection, View};

pub use self::{
    error::TruthError,
    record::{Truth, TruthStore},
};
use self::{
    lamp::{Aim, Lamp},
    ray::{Place, Ray},
    triangles::Triangles,
};

/// Pixels that a picture may have: an 8K picture's.
pub const MOST_PIXELS: usize = 1 << 25;
/// Rays that a light with an extent may have each way.
pub const MOST_STRATA: u32 = 64;

/// Casts rays through a scene, as it was when the tracer was made.
pub struct Tracer {
    triangles: Triangles,
    lights: Vec<Light>,
    /// Whether each casts shadows.
    casts: Vec<bool>,
    camera: umbrage_render::Camera,
}

/// Points that the pixels of a picture see.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sight {
    width: u32,
    height: u32,
    seen: Vec<Option<Seen>>,
}

/// A point that a pixel sees.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Seen {
    /// The object, by its place in [`Scene::objects`].
    pub object: u32,
    /// The triangle, by its place in the object's mesh.
    pub triangle: u32,
    /// The point: metres, world axes, relative to the camera.
    pub position: DVec3,
}

/// How large a light is taken to be.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Source {
    /// A point, or a single direction: the shadow term is 0 or 1.
    #[default]
    Sharp,
    /// A sphere around the light's position or, for a directional light, a disc in the sky.
    Round {
        /// The sphere's radius in metres, or the angle from the disc's middle to its edge in radians.
        size: f64,
        /// `strata`² rays a pixel; 1 to [`MOST_STRATA`].
        strata: u32,
    },
}

impl Sight {
    /// Pixels across.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Pixels down.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Points that the pixels see, by rows from the top.
    pub fn seen(&self) -> &[Option<Seen>] {
        &self.seen
    }
}

impl Tracer {
    /// A tracer of the scene as its camera sees it.
    ///
    /// # Errors
    /// A scene without triangles or lights, a vertex that is not finite or not there, a camera or a
    /// light that cannot be used.
    pub fn new(scene: &Scene) -> Result<Self, TruthError> {
        scene
            .camera
            .view(1, 1)
            .validate()
            .map_err(TruthError::Camera)?;
        if scene.lights.is_empty() {
            return Err(TruthError::NoLights);
        }
        let lights: Vec<_> = scene
            .lights
            .iter()
            .map(|light| light.light.clone())
            .collect();
        for (index, light) in lights.iter().enumerate() {
            light
                .validate()
                .map_err(|problem| TruthError::Light { index, problem })?;
        }
        Ok(Self {
            triangles: Triangles::new(scene, scene.camera.position)?,
            lights,
            casts: (scene.lights.iter())
                .map(|light| scene.casts_shadow(light))
                .collect(),
            camera: scene.camera,
        })
    }

    /// How many triangles there are.
    pub fn triangles(&self) -> usize {
        self.triangles.len()
    }

    /// Finds what each pixel's centre sees in a picture of the given size. `on_row` is called after
    /// each row, from any thread.
    ///
    /// # Errors
    /// A size of no pixels or more than [`MOST_PIXELS`].
    pub fn look(
        &self,
        width: u32,
        height: u32,
        on_row: &(dyn Fn() + Sync),
    ) -> Result<Sight, TruthError> {
        let pixels = u64::from(width) * u64::from(height);
        if pixels == 0 || pixels > MOST_PIXELS as u64 {
            return Err(TruthError::Size { width, height });
        }
        let view = self.camera.view(width, height);
        let mut seen = vec![None; pixels as usize];
        seen.par_chunks_mut(width as usize)
            .enumerate()
            .for_each(|(y, row)| {
                for (x, seen) in row.iter_mut().enumerate() {
                    *seen = self.see(&view, at(x, width), at(y, height));
                }
                on_row();
            });
        Ok(Sight {
            width,
            height,
            seen,
        })
    }

    /// Finds the shadow term of a light (by its place in [`Scene::lights`]) for each pixel: 1 where it is lit, and
    /// everywhere for a light that [casts no shadows](Scene::casts_shadow); 0 in shadow; none where nothing is seen,
    /// where the light does not reach, and where a sharp light runs along the surface. `on_row` is called after each
    /// row, from any thread.
    ///
    /// # Errors
    /// A light that is not there, a size that it cannot have, or a sight of another tracer's.
    pub fn shadow(
        &self,
        sight: &Sight,
        light: usize,
        source: Source,
        on_row: &(dyn Fn() + Sync),
    ) -> Result<Vec<Option<f32>>, TruthError> {
        let lamp = self.lamp(light)?;
        if let Source::Round { size, strata } = source
            && !lamp.can_be(source)
        {
            return Err(TruthError::Source { size, strata });
        }
        self.each(sight, on_row, |seen, pixel| match self.casts[light] {
            true => self.term(seen, &lamp, source, pixel),
            false => lamp.reaches(seen.position).then_some(1.0),
        })
    }

    /// Finds for each pixel how far along the ray to a light (by its place in [`Scene::lights`]) the
    /// nearest thing is that keeps it off; metres. None where the light arrives, does not reach, or
    /// nothing is seen: there is a distance where the [`Sharp`](Source::Sharp) shadow term is 0, and
    /// nowhere else. `on_row` is called after each row, from any thread.
    ///
    /// # Errors
    /// A light that is not there, or a sight of another tracer's.
    pub fn gaps(
        &self,
        sight: &Sight,
        light: usize,
        on_row: &(dyn Fn() + Sync),
    ) -> Result<Vec<Option<f64>>, TruthError> {
        let lamp = self.lamp(light)?;
        self.each(sight, on_row, |seen, _| {
            if !self.casts[light] {
                return None;
            }
            let (ray, own) = self.leave(seen, &lamp)?;
            let aim = lamp.middle(seen.position);
            if self.triangles.runs_along(own, aim.direction) {
                return None;
            }
            let distance = self.triangles.blocker(&ray(aim), own)?;
            Some(distance * aim.direction.length())
        })
    }

    /// Whether the light (by its place in [`Scene::lights`]) arrives at a point in the air: metres, world axes, relative to
    /// the camera. False where it does not reach.
    ///
    /// # Errors
    /// A light that is not there.
    pub fn arrives(&self, point: DVec3, light: usize) -> Result<bool, TruthError> {
        // No triangle's number: the point lies on none.
        const NONE: u32 = u32::MAX;
        let lamp = self.lamp(light)?;
        let at = Place {
            at: point,
            error: 0.0,
        };
        let ray = Ray::new(at, lamp.middle(point));
        Ok(lamp.reaches(point) && !self.triangles.is_blocked(&ray, NONE))
    }

    fn lamp(&self, light: usize) -> Result<Lamp, TruthError> {
        let count = self.lights.len();
        let known = self.lights.get(light);
        let light = known.ok_or(TruthError::NoSuchLight {
            index: light,
            count,
        })?;
        Ok(Lamp::new(&light.kind, self.camera.position))
    }

    /// Finds a value for each pixel that sees something, given its number; row by row.
    fn each<T: Copy + Send>(
        &self,
        sight: &Sight,
        on_row: &(dyn Fn() + Sync),
        find: impl Fn(&Seen, u64) -> Option<T> + Sync,
    ) -> Result<Vec<Option<T>>, TruthError> {
        let known = |seen: &Seen| self.triangles.number(seen.object, seen.triangle).is_some();
        if !sight.seen.iter().flatten().all(known) {
            return Err(TruthError::ForeignSight);
        }
        let width = sight.width as usize;
        let mut found = vec![None; sight.seen.len()];
        found
            .par_chunks_mut(width)
            .enumerate()
            .for_each(|(y, row)| {
                for (x, found) in row.iter_mut().enumerate() {
                    let pixel = y * width + x;
                    *found = sight.seen[pixel].and_then(|seen| find(&seen, pixel as u64));
                }
                on_row();
            });
        Ok(found)
    }

    /// Point seen at a place in the picture: from −1 to 1, right and down.
    fn see(&self, view: &View, across: f64, down: f64) -> Option<Seen> {
        let Projection { near, far, .. } = view.projection;
        let aside = 0.5 * view.projection.size_at(1.0) * DVec2::new(across, -down);
        let turn = |v: DVec3| view.rotation.normalize() * v;
        // One length of a ray is one metre of depth, which is what near and far are given in.
        let ray = |at: DVec3, direction: DVec3| {
            let direction = turn(direction);
            let aim = Aim {
                direction,
                end: None,
            };
            Ray::new(Place { at, error: 0.0 }, aim)
        };
        let found = match view.projection.field {
            Field::Perspective { .. } => {
                let ray = ray(DVec3::ZERO, aside.extend(-1.0));
                self.triangles.nearest(&ray, near, far)
            }
            Field::Orthographic { .. } => {
                let start = view.position - self.camera.position + turn(aside.extend(-near));
                let ray = ray(start, DVec3::NEG_Z);
                self.triangles.nearest(&ray, 0.0, far - near)
            }
        };
        let (triangle, position) = found?;
        let (object, triangle) = self.triangles.owner(triangle);
        Some(Seen {
            object,
            triangle,
            position,
        })
    }

    fn term(&self, seen: &Seen, lamp: &Lamp, source: Source, seed: u64) -> Option<f32> {
        let (ray, own) = self.leave(seen, lamp)?;
        let is_lit = |aim| !self.triangles.is_blocked(&ray(aim), own);
        let Source::Round { size, strata } = source else {
            let aim = lamp.middle(seen.position);
            // A triangle that the light runs along gets none of it, and whether it meets the next edge is chance.
            return (!self.triangles.runs_along(own, aim.direction))
                .then(|| f32::from(u8::from(is_lit(aim))));
        };
        let Some(rays) = lamp.spread(seen.position, size, strata, seed) else {
            return Some(1.0);
        };
        let lit = rays.filter(|aim| is_lit(*aim)).count();
        Some(lit as f32 / (strata * strata) as f32)
    }

    /// How rays leave a point in any direction, and the number of the triangle that it lies on; none
    /// where the light does not reach.
    fn leave(&self, seen: &Seen, lamp: &Lamp) -> Option<(impl Fn(Aim) -> Ray + use<>, u32)> {
        if !lamp.reaches(seen.position) {
            return None;
        }
        let own = self.triangles.number(seen.object, seen.triangle)?;
        let place = Place {
            at: seen.position,
            error: self.triangles.rounding(own),
        };
        Some((move |aim| Ray::new(place, aim), own))
    }
}

/// The centre of a pixel, from −1 to 1.
fn at(pixel: usize, of: u32) -> f64 {
    2.0 * (pixel as f64 + 0.5) / f64::from(of) - 1.0
}

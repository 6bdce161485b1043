//! Air of a stage, on the CPU, in f64: the steps of a ray are put where the shader puts them, and each asks the
//! method's twin.

use glam::{DVec2, DVec3};
use umbrage::{
    render::Scene,
    shadow::{Aabb, Light, LightKind, View},
};

use crate::{Oracle, Pixel};

/// How near to a light's range, its cone's side (as a share of either) or a map's edge (as a share of the distance from
/// the eye) a device may take a point for the other side: f32's cosines are the least exact, at angles this near.
const BORDER: f64 = 1e-4;

/// The box of air that something may shade.
pub(crate) fn shaded(scene: &Scene, view: &View, light: &Light) -> Option<Aabb> {
    scene.medium.filter(|air| air.scattering > 0.0)?;
    let seen = Aabb::from_points(view.frustum().corners())?;
    let around = match light.kind {
        LightKind::Directional { .. } => {
            let bounds = scene.objects.iter().map(|object| object.bounds);
            bounds.reduce(Aabb::union)?
        }
        LightKind::Spot {
            position, range, ..
        }
        | LightKind::Point { position, range } => Aabb {
            min: position - range,
            max: position + range,
        },
    };
    seen.intersection(around)
}

/// Ray that a pixel shows, from the eye.
struct Ray {
    /// Where the eye is, relative to the camera.
    origin: DVec3,
    direction: DVec3,
    begin: f64,
    end: f64,
}

/// A step: where, the metres that it stands for, dimmed on their way to the eye, and the light that arrives there
/// where nothing keeps it off, dimmed on its way.
struct Step {
    position: DVec3,
    weight: f64,
    light: f64,
}

impl Oracle<'_> {
    /// The share of the light from what the pixel sees that the air lets through.
    pub fn haze(&self, x: u32, y: u32, size: u32) -> Pixel {
        match self.air_ray(x, y, size) {
            Ok(ray) => {
                let left = (-self.extinction() * (ray.end - ray.begin)).exp();
                Pixel::Term(left, left)
            }
            Err(unsure) => unsure,
        }
    }

    /// The share of the light, scattered in the air before what the pixel sees, that shadows leave.
    pub fn shafts(&self, x: u32, y: u32, size: u32, steps: u32) -> Pixel {
        let ray = match self.air_ray(x, y, size) {
            Ok(ray) => ray,
            Err(unsure) => return unsure,
        };
        let (mut dark, mut lit, mut all) = (0.0, 0.0, 0.0);
        for step in self.steps(&ray, (x, y), steps) {
            let to_light = self.to_light(step.position).normalize();
            let g = self.stage.scene.medium.map_or(0.0, |air| air.anisotropy);
            // But for what all steps have in common.
            let phase = (1.0 + g * g - 2.0 * g * to_light.dot(ray.direction)).powf(-1.5);
            let scattered = step.weight * step.light * phase;
            if scattered > 0.0 {
                let [least, most] = self.term(step.position, DVec3::ZERO);
                dark += scattered * least;
                lit += scattered * most;
                all += scattered;
            }
        }
        if all > 0.0 {
            Pixel::Term(dark / all, lit / all)
        } else {
            Pixel::Background
        }
    }

    /// The least and the most texture fetches that the pixel's shafts take.
    ///
    /// # Errors
    /// Things that the pixel sees where it is unsure, or an edge where it is unsure whether a light reaches a step.
    pub fn air_fetches(&self, x: u32, y: u32, size: u32, steps: u32) -> Result<[u32; 2], Pixel> {
        let ray = self.air_ray(x, y, size)?;
        let cookie = u32::from(self.stage.scene.lights[0].cookie.is_some());
        // The depth of what is seen.
        let mut fetches = [1; 2];
        for step in self.steps(&ray, (x, y), steps) {
            if step.weight == 0.0 || !self.reached(step.position, 1.0 + BORDER) {
                continue;
            }
            let [least, most] = self.fetches_at(step.position, DVec3::ZERO);
            let near = DVec3::AXES.map(|axis| step.position.length() * BORDER * axis);
            let mut around = near
                .iter()
                .flat_map(|off| [step.position + off, step.position - off]);
            let sure = around.all(|near| self.fetches_at(near, DVec3::ZERO) == [least; 2]);
            if least != most || !sure || !self.reached(step.position, 1.0 - BORDER) {
                return Err(Pixel::Edge);
            }
            let shadow = self.range_of(least);
            fetches = [0, 1].map(|end| fetches[end] + shadow[end] + cookie);
        }
        Ok(fetches)
    }

    fn extinction(&self) -> f64 {
        self.stage.scene.medium.map_or(0.0, |air| air.extinction())
    }

    /// The pixel's ray; an edge where it, or one beside it, is near to another surface's.
    fn air_ray(&self, x: u32, y: u32, size: u32) -> Result<Ray, Pixel> {
        let view = &self.view;
        let at = |value: u32| 2.0 * (f64::from(value) + 0.5) / f64::from(size) - 1.0;
        let aside = 0.5 * view.projection.size_at(1.0) * DVec2::new(at(x), -at(y));
        // The ray's origin, and its vector for one metre of depth.
        let (origin, ray) = match view.projection.is_orthographic() {
            true => (view.rotation * aside.extend(0.0), DVec3::NEG_Z),
            false => (DVec3::ZERO, aside.extend(-1.0)),
        };
        let direction = view.rotation * ray.normalize();
        let end = match self.see(x, y, size, size) {
            Ok((_, position)) => position.distance(origin),
            Err(Pixel::Background) => {
                let beside = |at: u32| at.saturating_sub(1)..=(at + 1).min(size - 1);
                let sky = |(x, y)| matches!(self.see(x, y, size, size), Err(Pixel::Background));
                let mut around = beside(y).flat_map(|y| beside(x).map(move |x| (x, y)));
                if !around.all(sky) {
                    return Err(Pixel::Edge);
                }
                view.projection.far * ray.length()
            }
            Err(unsure) => return Err(unsure),
        };
        Ok(Ray {
            origin,
            direction,
            begin: view.projection.near * ray.length(),
            end,
        })
    }

    /// The steps along `ray`.
    fn steps(&self, ray: &Ray, (x, y): (u32, u32), steps: u32) -> impl Iterator<Item = Step> {
        // The plastic number's lattice.
        let place = x
            .wrapping_mul(3_242_174_889)
            .wrapping_add(y.wrapping_mul(2_447_445_413));
        let offset = (f64::from(place >> 24) + 0.5) / 256.0;
        (0..steps).map(move |step| {
            let share = (f64::from(step) + offset) / f64::from(steps);
            let (distance, weight) = self.step(ray, share);
            let position = ray.origin + distance * ray.direction;
            Step {
                position,
                weight,
                light: self.light(position),
            }
        })
    }

    /// How far from the eye the step at `share` of all is, and its weight.
    fn step(&self, ray: &Ray, share: f64) -> (f64, f64) {
        let sigma = self.extinction();
        let Some((place, range)) = self.lamp() else {
            let lost = 1.0 - (sigma * (ray.begin - ray.end)).exp();
            return (ray.begin - (1.0 - share * lost).ln() / sigma, lost / sigma);
        };
        let place = place - ray.origin;
        let middle = place.dot(ray.direction);
        let nearest = middle * ray.direction - place;
        let apart = nearest.length();
        let half = (range * range - apart * apart).max(0.0).sqrt();
        let (mut from, mut to) = (ray.begin.max(middle - half), ray.end.min(middle + half));
        if let LightKind::Spot {
            direction,
            outer_angle,
            ..
        } = self.stage.scene.lights[0].light.kind
        {
            // Where the cosine to the axis is the cone's: a (t − middle)² + b (t − middle) + c = 0.
            let (along, across) = (ray.direction.dot(direction), nearest.dot(direction));
            let cosine = outer_angle.cos().powi(2);
            let [a, b, c] = [
                along * along - cosine,
                2.0 * along * across,
                across * across - cosine * apart * apart,
            ];
            let root = (b * b - 4.0 * a * c).sqrt();
            let mut ends = [(-b - root) / (2.0 * a), (-b + root) / (2.0 * a)];
            ends.sort_by(f64::total_cmp);
            // Behind the light is the cone's other half.
            let inside = |t: f64| along * t + across > 0.0;
            let [low, high] = match ends.map(inside) {
                [true, true] => ends,
                [true, false] => [f64::NEG_INFINITY, ends[0]],
                [false, true] => [ends[1], f64::INFINITY],
                [false, false] => return (0.0, 0.0),
            };
            from = from.max(middle + low);
            to = to.min(middle + high);
        }
        if from >= to {
            return (0.0, 0.0);
        }
        let beside = (from - middle).max(middle - to);
        let apart = apart.max(beside).max(1e-3 * (to - from));
        let [first, last] = [from, to].map(|t| ((t - middle) / apart).atan());
        let along = apart * (first + (last - first) * share).tan();
        let metres = (last - first) * (apart * apart + along * along) / apart;
        let distance = middle + along;
        (distance, metres * (-sigma * (distance - ray.begin)).exp())
    }

    /// Where the light stands, relative to the camera, and its range; none for a directional one.
    fn lamp(&self) -> Option<(DVec3, f64)> {
        match self.stage.scene.lights[0].light.kind {
            LightKind::Directional { .. } => None,
            LightKind::Spot {
                position, range, ..
            }
            | LightKind::Point { position, range } => Some((position - self.view.position, range)),
        }
    }

    fn to_light(&self, position: DVec3) -> DVec3 {
        match self.stage.scene.lights[0].light.kind {
            LightKind::Directional { direction } => -direction,
            _ => self
                .lamp()
                .map_or(DVec3::ZERO, |(place, _)| place - position),
        }
    }

    /// Whether the light reaches the point, were its range and its cone's angle so many times as large.
    fn reached(&self, position: DVec3, scale: f64) -> bool {
        let offset = self.to_light(position);
        let ranged = self
            .lamp()
            .is_none_or(|(_, range)| offset.length() < scale * range);
        ranged
            && match self.stage.scene.lights[0].light.kind {
                LightKind::Spot {
                    direction,
                    outer_angle,
                    ..
                } => (-offset).angle_between(direction) < scale * outer_angle,
                _ => true,
            }
    }

    /// The light at a point where nothing keeps it off, but for a factor.
    fn light(&self, position: DVec3) -> f64 {
        let Some((place, range)) = self.lamp() else {
            return 1.0;
        };
        let distance = place.distance(position);
        let window = (1.0 - (distance / range).powi(4)).clamp(0.0, 1.0);
        let cone = match self.stage.scene.lights[0].light.kind {
            LightKind::Spot {
                direction,
                inner_angle,
                outer_angle,
                ..
            } => {
                let cosine = (position - place).dot(direction) / distance;
                let (inner, outer) = (inner_angle.cos(), outer_angle.cos());
                let share = ((cosine - outer) / (inner - outer)).clamp(0.0, 1.0);
                share * share * (3.0 - 2.0 * share)
            }
            _ => 1.0,
        };
        window * cone * (-self.extinction() * distance).exp() / (distance * distance)
    }
}

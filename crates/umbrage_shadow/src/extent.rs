//! The extent of a light's map: what it has to hold, and what is drawn into it.

use glam::DVec3;

use crate::{Aabb, Frustum, Lens, Rect, overlap};

/// The extent that a light's map has to hold: the receivers seen. Lengths in metres; see [`Lens`] for the space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// Where they lie in the lens's plane.
    pub rect: Rect,
    /// The least distance from the light along its axis.
    pub near: f64,
    /// The greatest.
    pub far: f64,
    /// Exactness of an f32 position among them; above 0.
    pub precision: f64,
}

impl Extent {
    /// Four units in the last place of an f32, relative: what positions, matrices and interpolation are
    /// trusted to.
    pub const PRECISION: f64 = 1.0 / 4_194_304.0;

    /// The parts of `receivers` that lie in all of `volumes`, from a light at `position` (zero if it
    /// has none); none where there is no such part. A perspective lens wants a volume that keeps
    /// off the light.
    pub fn of(
        lens: &Lens,
        position: DVec3,
        receivers: &[Aabb],
        volumes: &[&Frustum],
    ) -> Option<Self> {
        let parts = receivers
            .iter()
            .flat_map(|receiver| overlap(receiver, volumes));
        let points: Vec<DVec3> = parts.collect();
        let places = || points.iter().map(|p| lens.place(*p));
        let reach = points
            .iter()
            .map(|p| p.length())
            .fold(position.length(), f64::max);
        Some(Self {
            rect: Rect::from_points(places().map(|(at, _)| at))?,
            near: places()
                .map(|(_, distance)| distance)
                .fold(f64::INFINITY, f64::min),
            far: places()
                .map(|(_, distance)| distance)
                .fold(f64::NEG_INFINITY, f64::max),
            // A receiver that is one point at the origin has no reach, and is divided by.
            precision: (Self::PRECISION * reach).max(1e-15),
        })
    }

    /// How much farther than needed the near and far planes stand, relative: beyond any rounding.
    pub const PADDING: f64 = 1.0 / 8192.0;

    /// The nearest near plane of a light with a perspective, as a share of its range. Reversed depth keeps its
    /// relative precision over this ratio, and more.
    pub const NEAREST: f64 = 1e-5;

    /// Moves the near plane to the nearest of the casters between the light and what is seen, and both planes apart by
    /// more than rounding; those casters. With a perspective nothing is nearer than `floor` (metres from the light).
    pub fn take_casters(&mut self, lens: &Lens, floor: f64, casters: &[Aabb]) -> Vec<usize> {
        if lens.is_perspective() {
            self.far *= 1.0 + Self::PADDING;
            let beam = Beam::new(lens, &self.rect, floor, self.far, casters);
            self.near = (self.near.min(beam.near) * (1.0 - Self::PADDING)).max(floor);
            return beam.casters;
        }
        let corners = casters.iter().flat_map(Aabb::corners);
        let nearest = corners.map(|p| lens.place(p).1).fold(self.near, f64::min);
        let padding = Self::PADDING * (self.far - nearest) + 4.0 * self.precision;
        self.far += padding;
        let beam = Beam::new(lens, &self.rect, nearest - padding, self.far, casters);
        self.near = self.near.min(beam.near);
        self.near -= Self::PADDING * (self.far - self.near) + 4.0 * self.precision;
        beam.casters
    }

    /// The least extent that holds both.
    pub fn union(self, other: Self) -> Self {
        let (a, b) = (self.rect, other.rect);
        Self {
            rect: Rect {
                min: a.min.min(b.min),
                max: a.max.max(b.max),
            },
            near: self.near.min(other.near),
            far: self.far.max(other.far),
            precision: self.precision.max(other.precision),
        }
    }
}

/// The casters in a part of a light's volume.
#[derive(Clone, Debug, PartialEq)]
pub struct Beam {
    /// Their indices, ascending.
    pub casters: Vec<usize>,
    /// The least distance from the light at which one begins, inside the beam; metres, infinite
    /// where there is none.
    pub near: f64,
}

impl Beam {
    /// Nothing.
    pub const EMPTY: Self = Self {
        casters: Vec::new(),
        near: f64::INFINITY,
    };

    /// Those of `casters` that reach into `rect` of the lens's plane between `near` and `far`.
    pub fn new(lens: &Lens, rect: &Rect, near: f64, far: f64, casters: &[Aabb]) -> Self {
        let volume = Frustum::from_matrix(lens.matrix(rect, near, far));
        let mut beam = Self::EMPTY;
        for (i, caster) in casters.iter().enumerate() {
            let inside = overlap(caster, &[&volume]);
            if let Some(nearest) = inside.iter().map(|p| lens.place(*p).1).reduce(f64::min) {
                beam.casters.push(i);
                beam.near = beam.near.min(nearest);
            }
        }
        beam
    }
}

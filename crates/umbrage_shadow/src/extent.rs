//! The extent of a light's map: what it has to hold, and what is drawn into it.

use glam::DVec3;

use crate::{Aabb, Frustum, Lens, Rect, Side, Volume};

/// The extent that a light's map has to hold: the receivers seen. Lengths in metres; see [`Lens`] for the space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// Where they lie in the lens's plane.
    pub rect: Rect,
    /// The least distance from the light along its axis.
    pub near: f64,
    /// The greatest.
    pub far: f64,
    /// The greatest distance of theirs, and of the light's, from the origin.
    pub reach: f64,
}

impl Extent {
    /// Four units in the last place of an f32, relative: what positions, matrices and interpolation are
    /// trusted to.
    pub const PRECISION: f64 = 1.0 / 4_194_304.0;

    /// The parts of `receivers` that lie in all of `volumes`, from a light at `position` (zero if it
    /// has none); none where there is no such part. A perspective lens wants a volume that keeps
    /// off the light.
    pub fn of<'r>(
        lens: &Lens,
        position: DVec3,
        receivers: impl IntoIterator<Item = &'r Aabb>,
        volumes: &[&Frustum],
    ) -> Option<Self> {
        let mut volume = Volume::new(volumes);
        let mut seen = None::<Seen>;
        for receiver in receivers {
            let side = volume.side(receiver);
            if side == Side::Outside {
                continue;
            }
            let whole = lens.bound(receiver).map(|places| Seen {
                places,
                reach: receiver.reach(),
            });
            match whole {
                Some(whole) if side == Side::Inside => Seen::add(&mut seen, whole),
                // A part of it is no more than that.
                Some(whole) if seen.is_some_and(|seen| seen.holds(&whole)) => {}
                _ => {
                    for point in volume.cut(receiver) {
                        Seen::add(&mut seen, Seen::at(lens, *point));
                    }
                }
            }
        }
        seen.map(|Seen { places, reach }| Self {
            rect: Rect::of(&places),
            near: places.min.z,
            far: places.max.z,
            reach: reach.max(position.length()),
        })
    }

    /// Exactness of an f32 position among them, metres; above 0, as a receiver that is one point at the origin is divided by.
    pub fn precision(&self) -> f64 {
        (Self::PRECISION * self.reach).max(1e-15)
    }

    /// How much farther than needed the near and far planes stand, relative: beyond any rounding.
    pub const PADDING: f64 = 1.0 / 8192.0;

    /// The nearest near plane of a light with a perspective, as a share of its range. Reversed depth keeps its
    /// relative precision over this ratio, and more.
    pub const NEAREST: f64 = 1e-5;

    /// Moves the near plane to the nearest of the casters between the light and what is seen, and both planes apart by
    /// more than rounding; those casters. With a perspective nothing is nearer than `floor` (metres from the light).
    pub fn take_casters(&mut self, floor: f64, casters: &Placed<'_>) -> Vec<usize> {
        if casters.lens.is_perspective() {
            self.far *= 1.0 + Self::PADDING;
            let beam = Beam::new(casters, &self.rect, floor, self.far);
            self.near = (self.near.min(beam.near) * (1.0 - Self::PADDING)).max(floor);
            return beam.casters;
        }
        let nearest = casters
            .bound()
            .map_or(self.near, |all| self.near.min(all.min.z));
        let padding = Self::PADDING * (self.far - nearest) + 4.0 * self.precision();
        self.far += padding;
        let beam = Beam::new(casters, &self.rect, nearest - padding, self.far);
        self.near = self.near.min(beam.near);
        self.near -= Self::PADDING * (self.far - self.near) + 4.0 * self.precision();
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
            reach: self.reach.max(other.reach),
        }
    }
}

/// Bounds of what is seen so far.
#[derive(Clone, Copy)]
struct Seen {
    /// As [`Lens::bound`] has them.
    places: Aabb,
    /// The greatest distance from the origin.
    reach: f64,
}

impl Seen {
    fn at(lens: &Lens, point: DVec3) -> Self {
        let (at, distance) = lens.place(point);
        let place = at.extend(distance);
        Self {
            places: Aabb::new(place, place),
            reach: point.length(),
        }
    }

    fn add(all: &mut Option<Self>, more: Self) {
        *all = Some(all.map_or(more, |all| Self {
            places: all.places.union(more.places),
            reach: all.reach.max(more.reach),
        }));
    }

    fn holds(&self, other: &Self) -> bool {
        self.places.contains(&other.places) && other.reach <= self.reach
    }
}

/// Boxes, and where a lens places them: found once for all of a light's maps.
#[derive(Clone, Debug)]
pub struct Placed<'a> {
    lens: &'a Lens,
    boxes: &'a [Aabb],
    bounds: Vec<Option<Aabb>>,
}

impl<'a> Placed<'a> {
    /// Places `boxes`.
    pub fn new(lens: &'a Lens, boxes: &'a [Aabb]) -> Self {
        Self {
            lens,
            boxes,
            bounds: boxes.iter().map(|aabb| lens.bound(aabb)).collect(),
        }
    }

    /// The [bound](Lens::bound) of all of them, but for those that have none; none where there is no box. The shadows of a
    /// directional light's casters lie nowhere else.
    pub fn bound(&self) -> Option<Aabb> {
        self.bounds.iter().flatten().copied().reduce(Aabb::union)
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
    pub fn new(casters: &Placed<'_>, rect: &Rect, near: f64, far: f64) -> Self {
        let Placed {
            lens,
            boxes,
            bounds,
        } = casters;
        let held = Aabb::new(rect.min.extend(near), rect.max.extend(far));
        let frustum = Frustum::from_matrix(lens.matrix(rect, near, far));
        let mut volume = Volume::new(&[&frustum]);
        let middle = |caster: &Aabb| Seen::at(lens, caster.center()).places;
        let mut beam = Self::EMPTY;
        for (i, (caster, bound)) in boxes.iter().zip(bounds).enumerate() {
            let nearest = match bound {
                Some(bound) if !bound.intersects(&held) => continue,
                Some(bound) if held.contains(bound) => bound.min.z,
                // It reaches in, and no part of it is nearer than another caster.
                Some(bound) if beam.near <= bound.min.z && held.contains(&middle(caster)) => {
                    beam.near
                }
                None if volume.side(caster) == Side::Outside => continue,
                _ => {
                    let inside = volume.cut(caster).iter();
                    let Some(nearest) = inside.map(|p| lens.place(*p).1).reduce(f64::min) else {
                        continue;
                    };
                    nearest
                }
            };
            beam.casters.push(i);
            beam.near = beam.near.min(nearest);
        }
        beam
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::{View, overlap};

    fn vector(range: f64) -> impl Strategy<Value = DVec3> {
        [-range..range, -range..range, -range..range].prop_map(DVec3::from)
    }

    fn boxes() -> impl Strategy<Value = Vec<Aabb>> {
        let one = (vector(60.0), vector(1.0), 0usize..6).prop_map(|(at, size, flat)| {
            let mut half = 20.0 * size.abs().powf(3.0);
            if flat < 3 {
                half[flat] = 0.0;
            }
            Aabb::new(at - half, at + half)
        });
        prop::collection::vec(one, 0..24)
    }

    fn lens() -> impl Strategy<Value = (Lens, DVec3)> {
        let direction = vector(1.0).prop_map(|v| v.normalize_or(DVec3::NEG_Y));
        (direction, vector(30.0), any::<bool>()).prop_map(
            |(direction, position, spot)| match spot {
                true => (Lens::spot(position, direction), position),
                false => (Lens::directional(direction), DVec3::ZERO),
            },
        )
    }

    fn near_to(a: f64, b: f64) -> bool {
        a == b || (a - b).abs() < 1e-7 * (1.0 + a.abs())
    }

    proptest! {
        /// All parts cut out and all their vertices placed: the slow way.
        #[test]
        fn an_extent_holds_the_parts_seen_and_no_more(
            (lens, position) in lens(), receivers in boxes(), forward in vector(1.0), width in 0.1..1.2,
        ) {
            let view = View::perspective(DVec3::ZERO, forward, (1.0, 1.5), [0.1, 80.0]);
            let light = Frustum::from_matrix(lens.matrix(&Rect::square(width * 20.0), 0.5, 90.0));
            let narrow = Frustum::from_matrix(lens.matrix(&Rect::square(width), 0.5, 90.0));
            let light = if lens.is_perspective() { narrow } else { light };
            let volumes = [&view.frustum_relative(), &light];
            let extent = Extent::of(&lens, position, &receivers, &volumes);
            let points: Vec<_> = receivers.iter().flat_map(|aabb| overlap(aabb, &volumes)).collect();
            let places = points.iter().map(|point| {
                let (at, distance) = lens.place(*point);
                at.extend(distance)
            });
            let Some(slow) = Aabb::from_points(places) else {
                prop_assert_eq!(extent, None);
                return Ok(());
            };
            let reach = points.iter().map(|p| p.length()).fold(position.length(), f64::max);
            let Some(extent) = extent else { return Err(TestCaseError::fail("nothing seen")) };
            let found = [
                (extent.rect.min.x, slow.min.x), (extent.rect.min.y, slow.min.y), (extent.near, slow.min.z),
                (extent.rect.max.x, slow.max.x), (extent.rect.max.y, slow.max.y), (extent.far, slow.max.z),
                (extent.reach, reach),
            ];
            prop_assert!(found.iter().all(|(a, b)| near_to(*a, *b)), "{found:?}");
        }

        #[test]
        fn a_beam_has_the_casters_that_reach_into_it(
            (lens, _) in lens(), casters in boxes(), corner in [-1.0..1.0, -1.0..1.0], size in 0.01..1.0,
            near in 0.1..20.0, length in 0.1..60.0,
        ) {
            let spread = if lens.is_perspective() { 1.0 } else { 40.0 };
            let min = glam::DVec2::from(corner) * spread;
            let rect = Rect { min, max: min + size * spread };
            let beam = Beam::new(&Placed::new(&lens, &casters), &rect, near, near + length);
            let frustum = Frustum::from_matrix(lens.matrix(&rect, near, near + length));
            let mut slow = Beam::EMPTY;
            for (i, caster) in casters.iter().enumerate() {
                let inside = overlap(caster, &[&frustum]);
                if let Some(nearest) = inside.iter().map(|p| lens.place(*p).1).reduce(f64::min) {
                    slow.casters.push(i);
                    slow.near = slow.near.min(nearest);
                }
            }
            prop_assert_eq!(&beam.casters, &slow.casters);
            prop_assert!(near_to(beam.near, slow.near), "{} {}", beam.near, slow.near);
        }

        /// A box's bound is that of its corners' places.
        #[test]
        fn a_bound_is_of_all_corners((lens, _) in lens(), boxes in boxes()) {
            for aabb in boxes {
                let places = aabb.corners().map(|corner| lens.place(corner));
                let before = places.iter().all(|(_, distance)| *distance > 0.0);
                let expected = (before || !lens.is_perspective())
                    .then(|| places.map(|(at, distance)| at.extend(distance)))
                    .and_then(Aabb::from_points);
                let found = lens.bound(&aabb);
                prop_assert_eq!(found.is_some(), expected.is_some());
                for (a, b) in found.into_iter().zip(expected) {
                    let size = 1e-9 * (1.0 + b.reach());
                    prop_assert!(a.min.abs_diff_eq(b.min, size) && a.max.abs_diff_eq(b.max, size));
                }
            }
        }
    }
}

//! A light as a point sees it.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::DVec3;
use umbrage_shadow::LightKind;

use super::{MOST_STRATA, Source, ray::Place};

/// A light in the tracer's space.
pub(crate) enum Lamp {
    Sun {
        /// Unit.
        to_light: DVec3,
    },
    Bulb {
        position: DVec3,
        /// Greatest error of the position's coordinates: in the world they have no finer steps.
        error: f64,
        range: f64,
        /// The axis, and the cosine of the angle where the light ends.
        cone: Option<(DVec3, f64)>,
    },
}

/// Where to look from a point.
#[derive(Clone, Copy)]
pub(crate) struct Aim {
    /// Direction to the light: as long as the light is far, or of any length where the ray has no end.
    pub(crate) direction: DVec3,
    /// Position of the light; none for one infinitely far away.
    pub(crate) end: Option<Place>,
}

impl Lamp {
    pub(crate) fn new(kind: &LightKind, origin: DVec3) -> Self {
        match *kind {
            LightKind::Directional { direction } => Self::Sun {
                to_light: -direction,
            },
            LightKind::Spot {
                position,
                direction,
                outer_angle,
                range,
                ..
            } => Self::bulb(
                position,
                origin,
                range,
                Some((direction, outer_angle.cos())),
            ),
            LightKind::Point { position, range } => Self::bulb(position, origin, range, None),
        }
    }

    fn bulb(position: DVec3, origin: DVec3, range: f64, cone: Option<(DVec3, f64)>) -> Self {
        let at = position - origin;
        let largest = position.abs().max(at.abs()).max_element();
        Self::Bulb {
            position: at,
            error: Place::rounding(largest),
            range,
            cone,
        }
    }

    /// Whether the source is one that this light can be.
    pub(crate) fn can_be(&self, source: Source) -> bool {
        let Source::Round { size, strata } = source else {
            return true;
        };
        let most = match self {
            Self::Sun { .. } => FRAC_PI_2,
            Self::Bulb { .. } => f64::INFINITY,
        };
        size > 0.0 && size < most && (1..=MOST_STRATA).contains(&strata)
    }

    /// Whether the point would be lit if nothing stood between.
    pub(crate) fn reaches(&self, point: DVec3) -> bool {
        match self {
            Self::Sun { .. } => true,
            Self::Bulb {
                position,
                range,
                cone,
                ..
            } => {
                let offset = point - position;
                let distance = offset.length();
                let inside = |(axis, cosine): (DVec3, f64)| offset.dot(axis) > cosine * distance;
                distance < *range && distance > 0.0 && cone.is_none_or(inside)
            }
        }
    }

    /// Where a point light's one ray goes from a point.
    pub(crate) fn middle(&self, point: DVec3) -> Aim {
        match self {
            Self::Sun { to_light } => Aim {
                direction: *to_light,
                end: None,
            },
            Self::Bulb {
                position, error, ..
            } => Aim {
                direction: position - point,
                end: Some(Place {
                    at: *position,
                    error: *error,
                }),
            },
        }
    }

    /// Where the rays go from a point to a light of radius `size`: evenly over the solid angle, one in
    /// each of `strata`² parts of it, placed within its part by a hash of `seed`. None for a point
    /// within the light, where nothing can stand between.
    pub(crate) fn spread(
        &self,
        point: DVec3,
        size: f64,
        strata: u32,
        seed: u64,
    ) -> Option<impl Iterator<Item = Aim>> {
        let (axis, distance, sine, error) = match self {
            Self::Sun { to_light } => (*to_light, f64::INFINITY, size.sin(), 0.0),
            Self::Bulb {
                position, error, ..
            } => {
                let offset = position - point;
                let distance = offset.length();
                let error = error.max(Place::rounding(distance));
                (offset / distance, distance, size / distance, error)
            }
        };
        if sine >= 1.0 {
            return None;
        }
        // 1 - cos, without the cancellation.
        let depth = sine * sine / (1.0 + (1.0 - sine * sine).sqrt());
        let (right, up) = axis.any_orthonormal_pair();
        let count = u64::from(strata);
        Some((0..count * count).map(move |stratum| {
            let (x, y) = jitter(seed, stratum);
            let part = depth * ((stratum % count) as f64 + x) / count as f64;
            let (sin, cos) = (TAU * ((stratum / count) as f64 + y) / count as f64).sin_cos();
            let across = (part * (2.0 - part)).sqrt();
            let direction = (1.0 - part) * axis + across * (cos * right + sin * up);
            if distance.is_infinite() {
                return Aim {
                    direction,
                    end: None,
                };
            }
            // To the near side of the sphere.
            let half_chord = (size * size - (distance * across).powi(2)).max(0.0).sqrt();
            let direction = (distance * (1.0 - part) - half_chord) * direction;
            let at = point + direction;
            Aim {
                direction,
                end: Some(Place { at, error }),
            }
        }))
    }
}

/// Two numbers in 0..1 that have nothing to do with each other (SplitMix64: Steele, Lea and Flood 2014).
fn jitter(seed: u64, stratum: u64) -> (f64, f64) {
    let mix = |mut bits: u64| {
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        bits ^ (bits >> 31)
    };
    let bits = mix(mix(seed.wrapping_add(0x9e37_79b9_7f4a_7c15)).wrapping_add(stratum));
    let unit = |half: u32| f64::from(half) / 4_294_967_296.0;
    (unit((bits >> 32) as u32), unit(bits as u32))
}

//! Lights.

use std::f64::consts::FRAC_PI_2;

use glam::{DVec3, Vec3};

use crate::{Aabb, Constants, PlanError};

/// A light, as a shadow method sees it.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// Where its light comes from.
    pub kind: LightKind,
    /// Linear RGB: irradiance on a plane that faces a directional light; radiant intensity of others.
    pub color: Vec3,
}

/// Where a light's light comes from. World space: metres, f64.
#[derive(Clone, Debug, PartialEq)]
pub enum LightKind {
    /// From infinitely far away, along `direction` (unit, away from the light).
    Directional {
        /// Unit, away from the light.
        direction: DVec3,
    },
    /// From a point into a cone.
    Spot {
        /// Metres.
        position: DVec3,
        /// Unit, the cone's axis, away from the light.
        direction: DVec3,
        /// Angle from the axis at which the light begins to fade; radians.
        inner_angle: f64,
        /// Angle from the axis at which the light ends; radians, below π/2.
        outer_angle: f64,
        /// No light beyond; metres.
        range: f64,
    },
    /// From a point to all sides.
    Point {
        /// Metres.
        position: DVec3,
        /// No light beyond; metres.
        range: f64,
    },
}

impl LightKind {
    /// The kind's name: its value on the shader library's axis `light`.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Directional { .. } => "directional",
            Self::Spot { .. } => "spot",
            Self::Point { .. } => "point",
        }
    }
}

impl Light {
    /// The members of the uniform block `light` of our own lights' shaders, relative to a camera at `eye` (world).
    pub fn constants(&self, eye: DVec3) -> Constants {
        let vector = |v: DVec3| v.as_vec3();
        match self.kind {
            LightKind::Directional { direction } => Constants::new()
                .with("to_light", vector(-direction))
                .with("irradiance", self.color),
            LightKind::Spot {
                position,
                direction,
                inner_angle,
                outer_angle,
                range,
            } => Constants::new()
                .with("position_ws", vector(position - eye))
                .with("range", range as f32)
                .with("direction", vector(direction))
                .with("cos_outer", outer_angle.cos() as f32)
                .with("intensity", self.color)
                .with("cos_inner", inner_angle.cos() as f32),
            LightKind::Point { position, range } => Constants::new()
                .with("position_ws", vector(position - eye))
                .with("range", range as f32)
                .with("intensity", self.color),
        }
    }

    /// Checks that the light can shine.
    ///
    /// # Errors
    /// A colour, position or direction that is not finite; a colour below 0; a direction that is not
    /// of unit length; a range that is not above 0; angles out of order or not below π/2.
    pub fn validate(&self) -> Result<(), PlanError> {
        PlanError::check(
            self.color.is_finite() && self.color.min_element() >= 0.0,
            "the light's colour",
            self.color,
            "finite and not below 0",
        )?;
        match self.kind {
            LightKind::Directional { direction } => check_direction(direction),
            LightKind::Spot {
                position,
                direction,
                inner_angle,
                outer_angle,
                range,
            } => {
                check_place(position, range)?;
                check_direction(direction)?;
                PlanError::check(
                    outer_angle > 0.0 && outer_angle < FRAC_PI_2,
                    "the light's outer angle",
                    outer_angle,
                    "above 0 and below π/2",
                )?;
                // The light fades between the two angles' cosines, which f32 must tell apart.
                let apart = inner_angle.cos() - outer_angle.cos() > 4.0 * f64::from(f32::EPSILON);
                PlanError::check(
                    inner_angle >= 0.0 && inner_angle < outer_angle && apart,
                    "the light's inner angle",
                    inner_angle,
                    "from 0 to less than the outer angle, by as much as an f32 cosine tells",
                )
            }
            LightKind::Point { position, range } => check_place(position, range),
        }
    }

    /// Whether the light may reach the box (world space): never false where it does, sometimes true
    /// where it passes by. Shadows are not asked.
    pub fn reaches(&self, aabb: &Aabb) -> bool {
        match self.kind {
            LightKind::Directional { .. } => true,
            LightKind::Spot {
                position,
                direction,
                outer_angle,
                range,
                ..
            } => {
                aabb.intersects_sphere(position, range)
                    && cone_touches(position, direction, outer_angle, aabb)
            }
            LightKind::Point { position, range } => aabb.intersects_sphere(position, range),
        }
    }
}

/// Whether the endless cone may touch the box: whether it touches the ball around the box.
fn cone_touches(apex: DVec3, axis: DVec3, angle: f64, aabb: &Aabb) -> bool {
    let offset = aabb.center() - apex;
    let radius = 0.5 * (aabb.max - aabb.min).length();
    let along = offset.dot(axis);
    let across = (offset - along * axis).length();
    // The distance of the ball's centre from the cone's side, where that side is nearest.
    along >= -radius && across * angle.cos() - along * angle.sin() <= radius
}

fn check_direction(direction: DVec3) -> Result<(), PlanError> {
    PlanError::check(
        (direction.length() - 1.0).abs() < 1e-5,
        "the light's direction",
        direction,
        "of unit length",
    )
}

fn check_place(position: DVec3, range: f64) -> Result<(), PlanError> {
    PlanError::check(
        position.is_finite(),
        "the light's position",
        position,
        "finite",
    )?;
    PlanError::check(
        range > 0.0 && range.is_finite(),
        "the light's range",
        range,
        "finite and above 0",
    )
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn light(kind: LightKind) -> Light {
        Light {
            kind,
            color: Vec3::ONE,
        }
    }

    fn vector(range: f64) -> impl Strategy<Value = DVec3> {
        [-range..range, -range..range, -range..range].prop_map(DVec3::from)
    }

    proptest! {
        #[test]
        fn a_lit_point_is_reached(
            position in vector(5.0), toward in vector(1.0), outer_angle in 0.01..1.5,
            range in 0.1..20.0, (a, b) in (vector(20.0), vector(20.0)), t in vector(1.0),
        ) {
            let direction = toward.normalize_or(DVec3::Y);
            let aabb = Aabb { min: a.min(b), max: a.max(b) };
            let offset = aabb.center() + 0.5 * t * (aabb.max - aabb.min) - position;
            let inner_angle = 0.0;
            let spot = LightKind::Spot { position, direction, inner_angle, outer_angle, range };
            if offset.length() <= range {
                let point = light(LightKind::Point { position, range });
                prop_assert!(point.reaches(&aabb));
                prop_assert!(
                    offset.angle_between(direction) > outer_angle || light(spot).reaches(&aabb)
                );
            }
        }
    }

    #[test]
    fn a_box_behind_a_spot_or_out_of_range_is_not_reached() {
        let spot = light(LightKind::Spot {
            position: DVec3::ZERO,
            direction: DVec3::NEG_Z,
            inner_angle: 0.2,
            outer_angle: 0.4,
            range: 10.0,
        });
        let at = |p: DVec3| Aabb {
            min: p - 0.5,
            max: p + 0.5,
        };
        assert!(spot.reaches(&at(DVec3::new(0.0, 0.0, -5.0))));
        assert!(!spot.reaches(&at(DVec3::new(0.0, 0.0, 5.0))));
        assert!(!spot.reaches(&at(DVec3::new(0.0, 0.0, -15.0))));
        assert!(!spot.reaches(&at(DVec3::new(6.0, 0.0, -5.0))));
    }

    #[test]
    fn what_cannot_shine_is_named() {
        let nan = light(LightKind::Directional {
            direction: DVec3::NAN,
        });
        let zero = light(LightKind::Directional {
            direction: DVec3::ZERO,
        });
        let range = light(LightKind::Point {
            position: DVec3::ZERO,
            range: 0.0,
        });
        let message = |light: &Light| light.validate().err().map(|e| e.to_string());
        assert_eq!(
            message(&nan).as_deref(),
            Some("the light's direction is [NaN, NaN, NaN], but must be of unit length")
        );
        assert!(message(&zero).is_some());
        assert_eq!(
            message(&range).as_deref(),
            Some("the light's range is 0, but must be finite and above 0")
        );
        assert_eq!(
            message(&light(LightKind::Directional {
                direction: DVec3::Y
            })),
            None
        );
    }
}

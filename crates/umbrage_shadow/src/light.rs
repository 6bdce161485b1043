//! Lights.

use glam::{DVec3, Vec3};

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

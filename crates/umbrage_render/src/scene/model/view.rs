//! The lights and cameras of a glTF scene.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use glam::{DMat3, DQuat, DVec3, Vec3};
use serde::Deserialize;
use umbrage_shadow::{Field, LightKind};

use super::{Reader, SceneError, node::Placed};

/// A light, in glTF's units.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::scene) struct Lamp {
    pub(in crate::scene) name: String,
    /// With no end to its range where the file gives none.
    pub(in crate::scene) kind: LightKind,
    /// Linear RGB: lux of a directional light, candela of others.
    pub(in crate::scene) color: Vec3,
}

/// Where a picture is taken from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::scene) struct Eye {
    pub(in crate::scene) position: DVec3,
    /// From its axes to the scene's; it looks along −z of its own.
    pub(in crate::scene) rotation: DQuat,
    pub(in crate::scene) field: Field,
    pub(in crate::scene) near: f64,
    /// None without an end.
    pub(in crate::scene) far: Option<f64>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct LightFile {
    #[serde(rename = "type")]
    kind: String,
    name: Option<String>,
    #[serde(default = "white")]
    color: [f32; 3],
    #[serde(default = "one")]
    intensity: f32,
    range: Option<f64>,
    #[serde(default)]
    spot: Spot,
}

fn white() -> [f32; 3] {
    [1.0; 3]
}

fn one() -> f32 {
    1.0
}

#[derive(Deserialize)]
#[serde(default, rename_all = "camelCase")]
struct Spot {
    inner_cone_angle: f64,
    outer_cone_angle: f64,
}

impl Default for Spot {
    fn default() -> Self {
        Self {
            inner_cone_angle: 0.0,
            outer_cone_angle: FRAC_PI_4,
        }
    }
}

#[derive(Deserialize)]
struct CameraFile {
    #[serde(rename = "type")]
    kind: String,
    perspective: Option<Perspective>,
    orthographic: Option<Orthographic>,
}

#[derive(Deserialize)]
struct Perspective {
    yfov: f64,
    znear: f64,
    zfar: Option<f64>,
}

#[derive(Deserialize)]
struct Orthographic {
    ymag: f64,
    znear: f64,
    zfar: f64,
}

/// The widest cone that one map can be laid around.
const WIDEST: f64 = 89.0 / 180.0 * PI;

impl Reader<'_> {
    /// The light at a node, where it has one that shines.
    pub(super) fn light(&self, placed: &Placed) -> Result<Option<Lamp>, SceneError> {
        const LIGHTS: &str = "extensions.KHR_lights_punctual.lights";
        let document = self.document;
        let Some(number) = placed
            .node
            .extensions
            .light
            .as_ref()
            .map(|light| light.light)
        else {
            return Ok(None);
        };
        let file: LightFile = document.element(LIGHTS, number, &placed.place)?;
        let place = format!("{LIGHTS}[{}]", number.0);
        let invalid = |problem: String| Err(document.invalid(&place, problem));
        let color = Vec3::from(file.color) * file.intensity;
        if !color.is_finite() || color.min_element() < 0.0 {
            return invalid(format!(
                "its light is {color}, but must be finite and not negative"
            ));
        }
        let range = file.range.unwrap_or(f64::INFINITY);
        if range.is_nan() || range <= 0.0 {
            return invalid(format!("its range is {range}, but must be above 0"));
        }
        let position = placed.world.translation;
        let direction = placed.world.matrix3 * DVec3::NEG_Z;
        let Some(direction) = direction
            .try_normalize()
            .or((file.kind == "point").then_some(DVec3::ZERO))
        else {
            let instead = "a light that is scaled to nothing shines nowhere";
            self.notes.tell(
                "KHR_lights_punctual without a direction",
                instead,
                &placed.place,
            );
            return Ok(None);
        };
        let kind = match file.kind.as_str() {
            "directional" => LightKind::Directional { direction },
            "point" => LightKind::Point { position, range },
            "spot" => {
                let (inner, outer) = (file.spot.inner_cone_angle, file.spot.outer_cone_angle);
                // By as much more than a right angle as an f32 may round it.
                if !(0.0 <= inner && inner < outer && outer < FRAC_PI_2 + 1e-6) {
                    return invalid(format!(
                        "its cone is {inner} to {outer}, but must be of two angles from 0 to π/2"
                    ));
                }
                if outer > WIDEST {
                    let instead = "the light ends at 89 degrees from its axis";
                    self.notes
                        .tell("outerConeAngle beyond 89 degrees", instead, &placed.place);
                }
                let outer_angle = outer.clamp(PI / 180.0, WIDEST);
                LightKind::Spot {
                    position,
                    direction,
                    inner_angle: inner.min(0.999 * outer_angle),
                    outer_angle,
                    range,
                }
            }
            other => {
                return invalid(format!(
                    "its type is `{other}`, but must be directional, point or spot"
                ));
            }
        };
        let name = placed.node.name.clone().or(file.name);
        Ok(Some(Lamp {
            name: name.unwrap_or_else(|| placed.place.clone()),
            kind,
            color,
        }))
    }

    /// The camera at a node, where it has one.
    pub(super) fn eye(&self, placed: &Placed) -> Result<Option<Eye>, SceneError> {
        let document = self.document;
        let Some(number) = placed.node.camera else {
            return Ok(None);
        };
        let file: CameraFile = document.element("cameras", number, &placed.place)?;
        let place = format!("cameras[{}]", number.0);
        let invalid = |problem: String| Err(document.invalid(&place, problem));
        let (field, near, far) = match (file.kind.as_str(), &file.perspective, &file.orthographic) {
            ("perspective", Some(lens), _) => {
                if !(lens.yfov > 0.0 && lens.yfov < PI) {
                    let yfov = lens.yfov;
                    return invalid(format!("its yfov is {yfov}, but must lie between 0 and π"));
                }
                (
                    Field::Perspective { fov_y: lens.yfov },
                    lens.znear,
                    lens.zfar,
                )
            }
            ("orthographic", _, Some(lens)) => {
                if !(lens.ymag.abs() > 0.0 && lens.ymag.is_finite()) {
                    return invalid(format!("its ymag is {}, but must not be 0", lens.ymag));
                }
                // From the middle of the picture to its edge.
                let height = 2.0 * lens.ymag.abs();
                (Field::Orthographic { height }, lens.znear, Some(lens.zfar))
            }
            (kind @ ("perspective" | "orthographic"), ..) => {
                return invalid(format!("it is {kind}, but does not say how"));
            }
            (other, ..) => {
                return invalid(format!(
                    "its type is `{other}`, but must be perspective or orthographic"
                ));
            }
        };
        let least = match field {
            Field::Perspective { .. } => near > 0.0,
            Field::Orthographic { .. } => near >= 0.0,
        };
        if !least || far.is_some_and(|far| far.is_nan() || far <= near) {
            let far = far.map_or("no end".to_owned(), |far| far.to_string());
            return invalid(format!(
                "it sees from {near} to {far}, but must see from above 0 to farther away"
            ));
        }
        let linear = placed.world.matrix3;
        let Some(rotation) = upright(linear) else {
            let instead = "a camera that is scaled to nothing sees nothing";
            self.notes
                .tell("cameras without a direction", instead, &placed.place);
            return Ok(None);
        };
        Ok(Some(Eye {
            position: placed.world.translation,
            rotation,
            field,
            near,
            far,
        }))
    }
}

/// The rotation of a camera whose axes `linear` gives: its −z and the plane of its y are kept, without scale and
/// mirrors.
fn upright(linear: DMat3) -> Option<DQuat> {
    let back = linear.z_axis.try_normalize()?;
    let right = linear.y_axis.cross(back).try_normalize()?;
    let axes = DMat3::from_cols(right, back.cross(right), back);
    Some(DQuat::from_mat3(&axes))
}

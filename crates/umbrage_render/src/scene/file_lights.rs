//! Lights in scene files.

use std::{f64::consts::FRAC_PI_2, path::PathBuf};

use glam::DVec3;
use serde::Deserialize;
use umbrage_shadow::{Light, LightKind};

use super::{SceneError, SceneLight, Shadow, file::Loader};

/// A light in a scene file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename = "Light")]
pub(super) struct LightFile {
    name: Option<String>,
    kind: KindFile,
    #[serde(default = "white")]
    color: (f32, f32, f32),
    #[serde(default = "default_intensity")]
    intensity: f32,
    cookie: Option<PathBuf>,
    shadow: Option<Shadow>,
}

fn white() -> (f32, f32, f32) {
    (1.0, 1.0, 1.0)
}

fn default_intensity() -> f32 {
    1.0
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "snake_case", rename = "LightKind")]
enum KindFile {
    Directional {
        direction: (f64, f64, f64),
    },
    Spot {
        position: (f64, f64, f64),
        target: Option<(f64, f64, f64)>,
        direction: Option<(f64, f64, f64)>,
        inner_degrees: Option<f64>,
        outer_degrees: f64,
        range: f64,
    },
    Point {
        position: (f64, f64, f64),
        range: f64,
    },
}

impl Loader<'_> {
    /// The light that `file`, the scene file's `place`, describes.
    pub(super) fn light(&mut self, file: LightFile, place: &str) -> Result<SceneLight, SceneError> {
        let color = self.color(&format!("{place}.color"), file.color)?;
        self.number(
            format!("{place}.intensity"),
            f64::from(file.intensity),
            0.0..=1e30,
        )?;
        let kind = self.kind(&file.kind, &format!("{place}.kind"))?;
        let cookie = match (&file.cookie, &kind) {
            (None, _) => None,
            (Some(cookie), LightKind::Spot { .. }) => {
                Some(self.image(&format!("{place}.cookie"), cookie)?)
            }
            (Some(_), _) => {
                let problem = "only a spot light shines through a cookie";
                let remedy = "take the cookie away, or make the light a spot light";
                return Err(self.invalid(&format!("{place}.cookie"), problem, remedy));
            }
        };
        let light = Light {
            kind,
            color: color * file.intensity,
        };
        let name = file.name.unwrap_or_else(|| place.to_owned());
        Ok(SceneLight {
            name,
            light,
            cookie,
            shadow: file.shadow,
        })
    }

    fn kind(&self, file: &KindFile, place: &str) -> Result<LightKind, SceneError> {
        let position = |p| self.point(format!("{place}.position"), p);
        let range = |r| self.number(format!("{place}.range"), r, 1e-6..=1e12);
        Ok(match *file {
            KindFile::Directional { direction } => LightKind::Directional {
                direction: self.unit(place, direction)?,
            },
            KindFile::Point {
                position: p,
                range: r,
            } => LightKind::Point {
                position: position(p)?,
                range: range(r)?,
            },
            KindFile::Spot {
                position: p,
                target,
                direction,
                inner_degrees,
                outer_degrees,
                range: r,
            } => {
                let position = position(p)?;
                let direction = match (target, direction) {
                    (Some((x, y, z)), None) => {
                        let (x, y, z) = (x - position.x, y - position.y, z - position.z);
                        self.unit(place, (x, y, z))?
                    }
                    (None, Some(direction)) => self.unit(place, direction)?,
                    _ => {
                        let problem = "either a target or a direction says where the light shines";
                        return Err(self.invalid(place, problem, "give one of the two"));
                    }
                };
                let outer =
                    self.number(format!("{place}.outer_degrees"), outer_degrees, 1.0..=89.0)?;
                let inner = inner_degrees.unwrap_or(0.8 * outer);
                // The light fades between the two: there must be something between them.
                self.number(format!("{place}.inner_degrees"), inner, 0.0..=0.999 * outer)?;
                LightKind::Spot {
                    position,
                    direction,
                    inner_angle: inner.to_radians(),
                    outer_angle: outer.to_radians().min(FRAC_PI_2),
                    range: range(r)?,
                }
            }
        })
    }

    fn unit(&self, place: &str, (x, y, z): (f64, f64, f64)) -> Result<DVec3, SceneError> {
        let direction = self.point(format!("{place}.direction"), (x, y, z))?;
        direction.try_normalize().ok_or_else(|| {
            let problem = "it has no length";
            self.invalid(
                &format!("{place}.direction"),
                problem,
                "say where the light shines",
            )
        })
    }
}

//! The air's properties.

use serde::Deserialize;
use umbrage_shadow::{PlanError, plain_number};

use super::{SceneError, file::Loader};

/// Air that light is scattered and absorbed in, the same everywhere from the camera's near plane to its far plane:
/// haze, dust, smoke, water. Light is scattered once, towards the eye; what would be scattered again is lost, so that
/// dense media come out too dark. A directional light's irradiance is what arrives, and is not dimmed; others are, on
/// their way.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Medium {
    /// The share of light that is scattered, per metre; finite, and not below 0.
    #[serde(default)]
    pub scattering: f64,
    /// The share of light that is absorbed, per metre; finite, and not below 0.
    #[serde(default)]
    pub absorption: f64,
    /// The mean cosine of the angle by which light is scattered, the parameter of Henyey and Greenstein's (1941) phase
    /// function: −0.95 mostly back to where it came from, 0 to all sides alike, 0.95 mostly straight on.
    #[serde(default)]
    pub anisotropy: f64,
}

/// A thousand visible distances in a millimetre: nothing is seen through less.
const DENSEST: f64 = 1e6;

/// Nearer to 1, an f32 cosine does not tell how much is scattered straight on.
const MOST_ANISOTROPY: f64 = 0.95;

impl Medium {
    /// The share of light that is lost, per metre.
    pub fn extinction(&self) -> f64 {
        self.scattering + self.absorption
    }

    /// Checks that light can go through it.
    ///
    /// # Errors
    /// A number out of its range, or not a number.
    pub fn validate(&self) -> Result<(), PlanError> {
        for (name, value, least, most) in self.ranges() {
            let range = format!("from {} to {}", plain_number(least), plain_number(most));
            PlanError::check((least..=most).contains(&value), name, value, &range)?;
        }
        Ok(())
    }

    fn ranges(&self) -> [(&'static str, f64, f64, f64); 3] {
        [
            ("scattering", self.scattering, 0.0, DENSEST),
            ("absorption", self.absorption, 0.0, DENSEST),
            (
                "anisotropy",
                self.anisotropy,
                -MOST_ANISOTROPY,
                MOST_ANISOTROPY,
            ),
        ]
    }
}

impl Loader<'_> {
    /// `medium` as a scene file says it.
    pub(super) fn medium(&self, medium: Medium) -> Result<Medium, SceneError> {
        for (name, value, least, most) in medium.ranges() {
            self.number(format!("medium.{name}"), value, least..=most)?;
        }
        Ok(medium)
    }
}

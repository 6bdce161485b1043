//! Frames: the input of every plan.

use std::{collections::BTreeMap, fmt::Display};

use glam::{DVec2, DVec3};

use crate::{
    Aabb, Answers, Bias, DepthSource, Filter, Frustum, Light, Maps, Setting, Settings, ShadowPlan,
    View,
};

/// One light in one view, and what was chosen for its shadow.
#[derive(Clone, Copy)]
pub struct Frame<'a> {
    /// The camera.
    pub view: &'a View,
    /// The light.
    pub light: &'a Light,
    /// Bounds of casters and receivers.
    pub casters: Casters<'a>,
    /// Values of the chosen parts' settings, checked.
    pub settings: &'a Settings,
    /// The value of each of the chosen parts' axes.
    pub axes: &'a BTreeMap<String, String>,
    /// The source of the maps' depths, where it lets that be chosen.
    pub depth: Option<&'a dyn DepthSource>,
    /// The filter of the maps, where it lets that be chosen.
    pub filter: Option<&'a dyn Filter>,
    /// Pixels across and down the camera's depth, which passes may read ([`Reads::CAMERA_DEPTH`](crate::Reads::CAMERA_DEPTH));
    /// none where the engine has none to give.
    pub camera_depth: Option<[u32; 2]>,
    /// Answers to the [questions](ShadowPlan::asks) of earlier plans.
    pub answers: &'a Answers,
}

/// Bounds of what may cast and what may receive, world space.
#[derive(Clone, Copy, Debug, Default)]
pub struct Casters<'a> {
    /// Objects whose material casts.
    pub casters: &'a [Aabb],
    /// Objects that may be seen in the light.
    pub receivers: &'a [Aabb],
    /// The air that may be seen in the light, where there is any: a receiver that the camera's depth does not show.
    pub air: Option<Aabb>,
}

/// A frame's boxes relative to the camera: world axes, metres from [`View::position`].
#[derive(Clone, Debug, PartialEq)]
pub struct Bounds {
    /// The camera's position in the world.
    pub origin: DVec3,
    /// The camera's volume.
    pub camera: Frustum,
    /// All casters, in the frame's order.
    pub casters: Vec<Aabb>,
    /// The receivers that the light may reach, the air as the last one.
    pub receivers: Vec<Aabb>,
    /// Whether air is one of them.
    pub air: bool,
}

impl<'a> Frame<'a> {
    /// Checks the view, the light and the bounds: what every part wants before it plans.
    ///
    /// # Errors
    /// The first fault of [`View::validate`] or [`Light::validate`], or a box that is not finite.
    pub fn validate(&self) -> Result<(), PlanError> {
        self.view.validate()?;
        self.light.validate()?;
        let kinds = [
            ("caster", self.casters.casters),
            ("receiver", self.casters.receivers),
            ("air", self.casters.air.as_slice()),
        ];
        for (kind, boxes) in kinds {
            for (i, aabb) in boxes.iter().enumerate() {
                if !aabb.is_finite() {
                    return Err(PlanError::Invalid {
                        what: format!("the box of {kind} {i}"),
                        value: format!("{} to {}", aabb.min, aabb.max),
                        expected: "finite, and its corners in order".to_owned(),
                    });
                }
            }
        }
        Ok(())
    }

    /// The value of a setting, checked against its range: a frame may have been made by hand.
    ///
    /// # Errors
    /// A value that is missing, or out of range.
    pub fn setting(&self, setting: &Setting) -> Result<f64, PlanError> {
        let value = self.settings.get(setting.name);
        let holds = (setting.min..=setting.max).contains(&value);
        let what = format!("the setting `{}`", setting.name);
        let expected = format!("{} to {}", setting.min, setting.max);
        PlanError::check(holds, &what, value, &expected)?;
        Ok(value)
    }

    /// The value of an axis, "missing" where it has none.
    pub fn axis(&self, name: &str) -> &'a str {
        self.axes.get(name).map_or("missing", String::as_str)
    }

    /// Meaning of an axis's value, among `known`.
    ///
    /// # Errors
    /// A value that is not known.
    pub fn choice<T: Copy>(&self, axis: &str, known: &[(&str, T)]) -> Result<T, PlanError> {
        let value = self.axis(axis);
        let found = known.iter().find(|(known, _)| *known == value);
        found.map(|(_, found)| *found).ok_or_else(|| {
            let names: Vec<_> = known.iter().map(|(name, _)| *name).collect();
            PlanError::Invalid {
                what: format!("the axis `{axis}`"),
                value: value.to_owned(),
                expected: names.join(", "),
            }
        })
    }

    /// The boxes, relative to the camera.
    pub fn bounds(&self) -> Bounds {
        let origin = self.view.position;
        let Casters {
            casters,
            receivers,
            air,
        } = self.casters;
        let air = air.filter(|air| self.light.reaches(air));
        let lit = receivers.iter().filter(|r| self.light.reaches(r));
        let lit = lit.chain(&air);
        Bounds {
            origin,
            camera: self.view.frustum_relative(),
            casters: casters.iter().map(|c| c.translate(-origin)).collect(),
            receivers: lit.map(|r| r.translate(-origin)).collect(),
            air: air.is_some(),
        }
    }

    /// The depth source that was chosen.
    ///
    /// # Errors
    /// None was.
    pub fn depth(&self) -> Result<&'a dyn DepthSource, PlanError> {
        self.depth.ok_or_else(|| missing("depth source"))
    }

    /// The filter that was chosen.
    ///
    /// # Errors
    /// None was.
    pub fn filter(&self) -> Result<&'a dyn Filter, PlanError> {
        self.filter.ok_or_else(|| missing("filter"))
    }

    /// How far from a map's edge a place has to be for all that the filter reads about it to lie in map `number`,
    /// texels: the filter's [reach](Filter::reach), and a texel for rounding.
    ///
    /// # Errors
    /// The filter's.
    pub fn margin(&self, number: usize) -> Result<f64, PlanError> {
        Ok(self.reach(number)? + 1.0)
    }

    /// The filter's [reach](Filter::reach) in map `number`, texels.
    ///
    /// # Errors
    /// The filter's, and a reach that is no length.
    pub fn reach(&self, number: usize) -> Result<f64, PlanError> {
        let filter = self.filter()?;
        let reach = filter.reach(self, number)?;
        if reach.is_finite() && reach >= 0.0 {
            return Ok(reach);
        }
        Err(PlanError::Invalid {
            what: format!("the reach of the filter `{}`", filter.name()),
            value: reach.to_string(),
            expected: "finite, and not below 0".to_owned(),
        })
    }

    /// The filter's [bias](Filter::depth_bias), texels, where a scene chose `texels`.
    ///
    /// # Errors
    /// The filter's, and a bias that is not finite.
    pub fn depth_bias(&self, texels: f64, side: u32) -> Result<f64, PlanError> {
        let filter = self.filter()?;
        let bias = filter.depth_bias(self, texels, side)?;
        if bias.is_finite() {
            return Ok(bias);
        }
        Err(PlanError::Invalid {
            what: format!("the bias of the filter `{}`", filter.name()),
            value: bias.to_string(),
            expected: "finite".to_owned(),
        })
    }

    /// Bias of a receiver's depth d in a map before it is compared, towards the light, as x + y · d.
    ///
    /// # Errors
    /// There is no depth source.
    pub fn receiver_bias(&self, bias: &Bias) -> Result<DVec2, PlanError> {
        Ok(match self.depth()?.holds_bias() {
            true => DVec2::ZERO,
            false => bias.depth,
        })
    }

    /// Adds to `plan` what fills `maps` and what the filter makes of them, and how far the filter reads.
    ///
    /// # Errors
    /// Errors of the depth source and of the filter.
    pub fn fill(&self, maps: &Maps, plan: &mut ShadowPlan) -> Result<(), PlanError> {
        self.depth()?.fill(self, maps, plan)?;
        self.filter()?.prepare(self, maps, plan)?;
        plan.filter_radius = self.reach(0)?;
        Ok(())
    }
}

fn missing(kind: &str) -> PlanError {
    PlanError::Invalid {
        what: format!("the frame's {kind}"),
        value: "missing".to_owned(),
        expected: "there, as the method has its maps filled and sampled by other parts".to_owned(),
    }
}

/// Why a part could not plan.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PlanError {
    /// The method does not support the light.
    #[error("method `{method}` cannot shadow this light: {reason}")]
    Unsupported {
        /// The method.
        method: String,
        /// Why.
        reason: String,
    },
    /// A number in the frame is not finite, or out of its range.
    #[error("{what} is {value}, but must be {expected}")]
    Invalid {
        /// Which number.
        what: String,
        /// As found.
        value: String,
        /// As it must be.
        expected: String,
    },
}

impl PlanError {
    /// [`PlanError::Invalid`] unless `holds`: `what` (a lowercase fragment) is `value`, but must be
    /// `expected`.
    ///
    /// # Errors
    /// Where `holds` is false.
    pub fn check(
        holds: bool,
        what: &str,
        value: impl Display,
        expected: &str,
    ) -> Result<(), PlanError> {
        if holds {
            return Ok(());
        }
        Err(Self::Invalid {
            what: what.to_owned(),
            value: value.to_string(),
            expected: expected.to_owned(),
        })
    }
}

//! A scene to plan for, and its plan's parts.
#![allow(clippy::panic, reason = "a helper that panics fails its test")]
#![allow(dead_code, reason = "each test program uses its own part")]

use std::collections::BTreeMap;

use glam::{DMat4, DQuat, DVec2, DVec3, Vec3};
use umbrage_methods::registry;
use umbrage_shadow::*;

#[derive(Clone, Debug)]
pub(crate) struct Scene {
    pub(crate) view: View,
    pub(crate) light: Light,
    pub(crate) casters: Vec<Aabb>,
    pub(crate) receivers: Vec<Aabb>,
    pub(crate) air: Option<Aabb>,
    pub(crate) camera_depth: Option<[u32; 2]>,
    pub(crate) answers: Answers,
    axes: BTreeMap<String, String>,
    pub(crate) settings: BTreeMap<String, f64>,
}

impl Scene {
    pub(crate) fn new(kind: LightKind) -> Self {
        let axes = [
            ("depth", "nearest"),
            ("block", "4"),
            ("filter", "pcf"),
            ("fit", "stable"),
            ("lookup", "packed"),
            ("taper", "off"),
            ("pcf", "3"),
            ("range", "boxes"),
            ("receiver_bias", "plane"),
            ("transition", "hard"),
        ];
        Self {
            view: View {
                position: DVec3::ZERO,
                rotation: DQuat::IDENTITY,
                projection: Projection {
                    field: Field::Perspective { fov_y: 1.0 },
                    aspect: 1.5,
                    near: 0.05,
                    far: 200.0,
                },
                eye: 0.0,
            },
            light: Light {
                kind,
                color: Vec3::ONE,
            },
            air: None,
            camera_depth: None,
            answers: Answers::default(),
            casters: Vec::new(),
            receivers: Vec::new(),
            axes: axes.map(|(a, v)| (a.to_owned(), v.to_owned())).into(),
            settings: BTreeMap::new(),
        }
    }

    /// The same for `basic`: a map of 256 texels, half a texel of bias.
    pub(crate) fn basic(kind: LightKind) -> Self {
        let mut scene = Self::new(kind);
        scene.set("resolution", 256.0);
        scene.set("depth_bias", 0.5);
        scene
    }

    pub(crate) fn transformed(&self, scale: f64, offset: DVec3) -> Self {
        let mut scene = self.clone();
        let place = |p: DVec3| p * scale + offset;
        scene.view.position = place(self.view.position);
        scene.view.projection.near *= scale;
        scene.view.projection.far *= scale;
        match &mut scene.light.kind {
            LightKind::Directional { .. } => {}
            LightKind::Spot {
                position, range, ..
            }
            | LightKind::Point { position, range } => {
                *position = place(*position);
                *range *= scale;
            }
        }
        for aabb in scene.casters.iter_mut().chain(&mut scene.receivers) {
            *aabb = Aabb {
                min: place(aabb.min),
                max: place(aabb.max),
            };
        }
        scene
    }

    /// Has these cast and receive.
    pub(crate) fn hold(&mut self, boxes: Vec<Aabb>) {
        self.casters.clone_from(&boxes);
        self.receivers = boxes;
    }

    /// The filter's width, texels.
    pub(crate) fn width(&self) -> f64 {
        self.axes["pcf"].parse().expect("a width")
    }

    pub(crate) fn choose(&mut self, axis: &str, value: &str) {
        self.axes.insert(axis.to_owned(), value.to_owned());
    }

    pub(crate) fn set(&mut self, setting: &str, value: f64) {
        self.settings.insert(setting.to_owned(), value);
    }

    pub(crate) fn plan(&self) -> Result<ShadowPlan, PlanError> {
        self.plan_with("pssm")
    }

    pub(crate) fn plan_with(&self, method: &str) -> Result<ShadowPlan, PlanError> {
        let chosen = self.settings.iter().map(|(name, v)| (name.as_str(), *v));
        let registry = registry().expect("names differ");
        let value = |axis: &str| self.axes.get(axis).map(String::as_str);
        let choice = registry.choose(method, value).expect("parts");
        let settings = Settings::check(&choice.settings(), chosen).expect("settings in range");
        choice.method.plan(&Frame {
            view: &self.view,
            light: &self.light,
            casters: Casters {
                casters: &self.casters,
                receivers: &self.receivers,
                air: self.air,
            },
            settings: &settings,
            axes: &self.axes,
            depth: choice.depth.as_deref(),
            filter: choice.filter.as_deref(),
            camera_depth: self.camera_depth,
            answers: &self.answers,
        })
    }
}

impl Scene {
    /// Answers what pixels see: the least and the greatest view depth, metres; nothing where the first is greater.
    pub(crate) fn answer(&mut self, [least, most]: [f64; 2]) {
        let [far, step] = self.view.projection.depth_terms();
        let depth = |view_depth: f64| ((1.0 / view_depth - far) / step) as f32;
        let words = match least > most {
            true => [0; 2],
            false => [depth(least).to_bits(), !depth(most).to_bits()],
        };
        let bytes = words.into_iter().flat_map(u32::to_le_bytes).collect();
        self.answers = Answers::default().with([("seen_depths".to_owned(), bytes)]);
    }
}

pub(crate) fn lamp() -> LightKind {
    LightKind::Spot {
        position: DVec3::new(2.0, 9.0, -4.0),
        direction: DVec3::new(-0.2, -1.0, -0.3).normalize(),
        inner_angle: 0.3,
        outer_angle: 0.8,
        range: 40.0,
    }
}

pub(crate) fn sun() -> LightKind {
    LightKind::Directional {
        direction: DVec3::new(0.4, -1.0, 0.3).normalize(),
    }
}

/// A flat ground at height 0, `half` metres to each side.
pub(crate) fn ground(half: f64) -> Aabb {
    Aabb {
        min: DVec3::new(-half, 0.0, -half),
        max: DVec3::new(half, 0.0, half),
    }
}

/// Half a metre to each side, from `foot` up.
pub(crate) fn post(foot: DVec3, height: f64) -> Aabb {
    Aabb {
        min: foot - DVec3::new(0.5, 0.0, 0.5),
        max: foot + DVec3::new(0.5, height, 0.5),
    }
}

pub(crate) fn passes(plan: &ShadowPlan) -> Vec<CasterPass> {
    let casters = plan.passes.iter().filter_map(|pass| match pass {
        Pass::Casters(pass) => Some(pass.clone()),
        _ => None,
    });
    casters.collect()
}

pub(crate) fn matrix(plan: &ShadowPlan, name: &str) -> DMat4 {
    match plan.constants.get(name) {
        Some(Value::Mat4(value)) => value.as_dmat4(),
        other => panic!("{name}: {other:?}"),
    }
}

pub(crate) fn pair(plan: &ShadowPlan, name: &str) -> DVec2 {
    match plan.constants.get(name) {
        Some(Value::Vec2(value)) => value.as_dvec2(),
        other => panic!("{name}: {other:?}"),
    }
}

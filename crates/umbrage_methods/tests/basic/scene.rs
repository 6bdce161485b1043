//! A scene to plan for, and its plan's parts.

use std::collections::BTreeMap;

use glam::{DMat4, DQuat, DVec2, DVec3, Vec3};
use umbrage_methods::registry;
use umbrage_shadow::*;

pub(crate) fn plan(scene: &Scene) -> Result<ShadowPlan, PlanError> {
    let chosen = [
        ("resolution", scene.resolution),
        ("depth_bias", scene.depth_bias),
    ];
    let axes = BTreeMap::from([
        ("pcf".to_owned(), scene.width.to_string()),
        ("receiver_bias".to_owned(), "plane".to_owned()),
        ("depth".to_owned(), scene.depth.to_owned()),
        ("block".to_owned(), "4".to_owned()),
        ("filter".to_owned(), scene.filter.to_owned()),
    ]);
    let registry = registry().expect("names differ");
    let value = |axis: &str| axes.get(axis).map(String::as_str);
    let choice = registry.choose("basic", value).expect("parts");
    let settings = Settings::check(&choice.settings(), chosen).expect("settings in range");
    choice.method.plan(&Frame {
        view: &scene.view,
        light: &scene.light,
        casters: Casters {
            casters: &scene.casters,
            receivers: &scene.receivers,
            air: false,
        },
        settings: &settings,
        axes: &axes,
        depth: choice.depth,
        filter: choice.filter,
        camera_depth: None,
        answers: Answers::none(),
    })
}

#[derive(Clone, Debug)]
pub(crate) struct Scene {
    pub(crate) view: View,
    pub(crate) light: Light,
    pub(crate) casters: Vec<Aabb>,
    pub(crate) receivers: Vec<Aabb>,
    pub(crate) resolution: f64,
    pub(crate) depth_bias: f64,
    pub(crate) width: u32,
    pub(crate) depth: &'static str,
    pub(crate) filter: &'static str,
}

impl Scene {
    pub(crate) fn new(kind: LightKind) -> Self {
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
            casters: Vec::new(),
            receivers: Vec::new(),
            resolution: 256.0,
            depth_bias: 0.5,
            width: 3,
            depth: "nearest",
            filter: "pcf",
        }
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
}

pub(crate) fn casters(plan: &ShadowPlan) -> Vec<CasterPass> {
    let passes = plan.passes.iter().map(|pass| match pass {
        Pass::Casters(pass) => pass.clone(),
        _ => panic!("{pass:?}"),
    });
    passes.collect()
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

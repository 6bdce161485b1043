//! Sheets and a camera below them.

use std::{collections::BTreeMap, sync::Arc};

use glam::{DAffine3, DMat3, DMat4, DQuat, DVec2, DVec3, Vec2, Vec3, Vec4};
use umbrage::{
    compose::{Composer, Target},
    render::{
        Camera, Gpu, Material, Mesh, Object, Picture, RenderOptions, Renderer, Scene, SceneLight,
        Shadow, What,
    },
    shadow::{Field, Light, LightKind, Pass, ShadowPlan, Value},
};

/// Texels along the maps, if nothing else is said: a prime, so that no part of a pass divides it.
pub(crate) const RESOLUTION: f64 = 509.0;

pub(crate) const FILTERS: [&str; 3] = ["esm", "esm_half", "esm_log"];

/// Half the angle that the camera sees, as a tangent.
const SPREAD: f64 = 0.5;

/// A rectangle: from and to, x and z, and its height at x = 0; metres.
#[derive(Clone, Copy)]
pub(crate) struct Sheet {
    pub(crate) min: DVec2,
    pub(crate) max: DVec2,
    pub(crate) height: f64,
}

pub(crate) fn sheet(half: f64, height: f64) -> Sheet {
    Sheet {
        min: DVec2::splat(-half),
        max: DVec2::splat(half),
        height,
    }
}

/// Filter and map that a scene is drawn with.
pub(crate) struct Choice {
    pub(crate) filter: &'static str,
    pub(crate) width: u32,
    /// 0: chosen by the method.
    pub(crate) exponent: f64,
}

/// Terms, and where each was taken: x and z.
pub(crate) struct Drawn {
    pub(crate) terms: Vec<f64>,
    pub(crate) places: Vec<DVec2>,
    pub(crate) plan: ShadowPlan,
}

impl Drawn {
    /// The terms at places that `wanted` picks, 10 at the least.
    pub(crate) fn at(&self, wanted: impl Fn(DVec2) -> bool) -> Vec<(DVec2, f64)> {
        let all = self.places.iter().copied().zip(self.terms.iter().copied());
        let found: Vec<_> = all.filter(|(place, _)| wanted(*place)).collect();
        assert!(found.len() >= 10, "{} pixels", found.len());
        found
    }

    /// Camera-relative to the map's clip space.
    pub(crate) fn view_proj(&self) -> DMat4 {
        match self.plan.passes.first() {
            Some(Pass::Casters(pass)) => pass.view_proj.as_dmat4(),
            _ => panic!("no casters' pass"),
        }
    }

    /// The range of distances that the map holds, metres, and the wider side of its texels.
    pub(crate) fn range(&self) -> (f64, f64) {
        let to_world = self.view_proj().inverse();
        let step = |axis: DVec3| to_world.transform_vector3(axis).length();
        let texel = 2.0 * step(DVec3::X).max(step(DVec3::Y)) / RESOLUTION;
        (step(DVec3::Z), texel)
    }

    /// A receiver's bias, as a share of the range.
    pub(crate) fn bias(&self) -> f64 {
        match self.plan.constants.get("bias") {
            Some(Value::Vec2(bias)) => bias.x.into(),
            _ => panic!("no bias"),
        }
    }

    /// The exponent of the first map.
    pub(crate) fn exponent(&self) -> f64 {
        let Some(Value::Array(tiles)) = self.plan.constants.get("esm_tiles") else {
            panic!("no exponential maps");
        };
        match &tiles[0] {
            Value::Struct(tile) => match tile.get("exponent") {
                Some(Value::F32(exponent)) => f64::from(*exponent),
                _ => panic!("no exponent"),
            },
            _ => panic!("no struct"),
        }
    }
}

pub(crate) struct Studio {
    renderer: Renderer,
    /// Pixels along the pictures.
    pub(crate) size: u32,
    /// Texels along the maps.
    pub(crate) resolution: f64,
    /// The light's direction.
    pub(crate) sun: DVec3,
    /// By how much the height of all sheets grows with x.
    pub(crate) slope: f64,
}

impl Studio {
    pub(crate) fn new() -> Self {
        let gpu = Arc::new(Gpu::new().unwrap_or_else(|error| panic!("{error}")));
        let library = umbrage::shader_library().expect("the shader library is sound");
        let composer = Arc::new(Composer::new(library, Target::webgpu()));
        let registry = umbrage::methods::registry().expect("names are unique");
        Self {
            renderer: Renderer::new(gpu, composer, registry),
            size: 128,
            resolution: RESOLUTION,
            sun: DVec3::NEG_Y,
            slope: 0.0,
        }
    }

    /// The first sheet as seen from the height `eye`, straight up.
    pub(crate) fn draw(&mut self, sheets: &[Sheet], eye: f64, choice: &Choice) -> Drawn {
        self.draw_sheet(sheets, (eye, sheets[0].height), choice)
    }

    /// The same; places are where it sees the height `seen`.
    pub(crate) fn draw_sheet(
        &mut self,
        sheets: &[Sheet],
        (eye, seen): (f64, f64),
        choice: &Choice,
    ) -> Drawn {
        let scene = self.scene(sheets, eye, choice);
        let options = RenderOptions {
            width: self.size,
            height: self.size,
            what: What::ShadowTerm,
            ..RenderOptions::default()
        };
        let rendered = self.renderer.render(&scene, &options);
        let rendered = rendered.unwrap_or_else(|error| panic!("{error}"));
        let Picture::ShadowTerm(terms) = rendered.picture else {
            panic!("a shadow term was asked for");
        };
        let place = |pixel: u32| {
            let at = |number: u32| 2.0 * (f64::from(number) + 0.5) / f64::from(self.size) - 1.0;
            // The camera's right is x; what it has for up is z.
            let across = DVec2::new(at(pixel % self.size), -at(pixel / self.size)) * SPREAD;
            across * (seen - eye) / (1.0 - self.slope * across.x)
        };
        Drawn {
            terms: terms[0].iter().map(|term| f64::from(*term)).collect(),
            places: (0..self.size * self.size).map(place).collect(),
            plan: rendered.report.plans[0].as_deref().expect("a plan").clone(),
        }
    }

    fn scene(&self, sheets: &[Sheet], eye: f64, choice: &Choice) -> Scene {
        let objects = sheets.iter().map(|sheet| {
            let size = (sheet.max - sheet.min).as_vec2();
            let middle = 0.5 * (sheet.min + sheet.max);
            let height = sheet.height + self.slope * middle.x;
            let transform = DAffine3 {
                matrix3: DMat3::from_cols(
                    DVec3::new(1.0, self.slope, 0.0),
                    DVec3::new(-self.slope, 1.0, 0.0),
                    DVec3::Z,
                ),
                translation: DVec3::new(middle.x, height, middle.y),
            };
            let mesh = Arc::new(Mesh::plane(size, Vec2::ONE));
            let mut material = Material::plain("lambert");
            material.base_color = Vec4::ONE;
            Object {
                name: "sheet".to_owned(),
                bounds: mesh.bounds(&transform),
                mesh,
                material: Arc::new(material),
                transform,
            }
        });
        let axes = [
            ("filter", choice.filter.to_owned()),
            ("pcf", choice.width.to_string()),
        ];
        let mut settings = BTreeMap::from([
            ("resolution".to_owned(), self.resolution),
            ("depth_bias".to_owned(), 0.0),
        ]);
        if choice.filter != "pcf" {
            settings.insert("exponent".to_owned(), choice.exponent);
        }
        Scene {
            objects: objects.collect(),
            lights: vec![SceneLight {
                name: "sun".to_owned(),
                light: Light {
                    kind: LightKind::Directional {
                        direction: self.sun,
                    },
                    color: Vec3::ONE,
                },
                cookie: None,
                shadow: Some(Shadow {
                    method: "basic".to_owned(),
                    axes: axes.map(|(axis, value)| (axis.to_owned(), value)).into(),
                    settings,
                }),
            }],
            camera: Camera {
                position: DVec3::new(0.0, eye, 0.0),
                rotation: DQuat::from_rotation_x(90f64.to_radians()),
                field: Field::Perspective {
                    fov_y: 2.0 * SPREAD.atan(),
                },
                near: 0.05,
                far: 100.0,
            },
            ambient: Vec3::ZERO,
            background: Vec3::ZERO,
            medium: None,
            left_out: Vec::new(),
        }
    }
}

/// Relative error of a term by rounding. Positions, depths and exponentials of f32 differ by a few units in the last of 24
/// bits, which the exponent multiplies; each of the two maps and the fetch may round to 11 bits in halves.
pub(crate) fn rounding(filter: &str, exponent: f64) -> f64 {
    let halves = if filter == "esm_half" {
        3.0 / 2048.0
    } else {
        0.0
    };
    exponent * 16.0 / 16_777_216.0 + 1e-4 + halves
}

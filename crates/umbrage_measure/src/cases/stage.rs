//! Building scenes in code: what each needs, in a line.

use std::{collections::BTreeMap, sync::Arc};

use glam::{DAffine3, DQuat, DVec2, DVec3, Vec2, Vec3};
use umbrage_render::{Camera, Material, Mesh, Object, Scene, SceneLight};
use umbrage_shadow::{Field, Light, LightKind, look_along};

use super::Case;

/// Linear RGB.
pub(super) type Color = [f32; 3];

pub(super) const GROUND: Color = [0.55, 0.52, 0.46];
pub(super) const STONE: Color = [0.66, 0.63, 0.60];
pub(super) const BRICK: Color = [0.62, 0.24, 0.15];
pub(super) const OCHRE: Color = [0.74, 0.50, 0.13];
pub(super) const GREEN: Color = [0.20, 0.42, 0.14];
pub(super) const BLUE: Color = [0.17, 0.33, 0.60];

/// A scene that is being built.
#[derive(Clone)]
pub(super) struct Stage(Scene);

impl Stage {
    pub(super) fn new(camera: Camera) -> Self {
        Self(Scene {
            objects: Vec::new(),
            lights: Vec::new(),
            camera,
            ambient: Vec3::new(0.10, 0.12, 0.16),
            background: Vec3::new(0.32, 0.48, 0.70),
            medium: None,
            left_out: Vec::new(),
        })
    }

    /// A level ground around the origin, `width` along x and `depth` along z.
    pub(super) fn ground(&mut self, width: f32, depth: f32) -> &mut Self {
        let plane = Mesh::plane(Vec2::new(width, depth), Vec2::ONE);
        self.put("ground", plane, GROUND, at(0.0, 0.0, 0.0))
    }

    /// A box that stands on the level of `foot`, whose middle `foot` is.
    pub(super) fn block(
        &mut self,
        name: &str,
        size: DVec3,
        color: Color,
        foot: DVec3,
    ) -> &mut Self {
        let centre = foot + DVec3::Y * 0.5 * size.y;
        let place = DAffine3::from_translation(centre);
        self.put(name, Mesh::cuboid(size.as_vec3()), color, place)
    }

    pub(super) fn ball(&mut self, radius: f64, color: Color, centre: DVec3) -> &mut Self {
        let mesh = Mesh::sphere(radius as f32, 64);
        self.put("ball", mesh, color, DAffine3::from_translation(centre))
    }

    pub(super) fn put(
        &mut self,
        name: &str,
        mesh: impl Into<Arc<Mesh>>,
        color: Color,
        transform: DAffine3,
    ) -> &mut Self {
        let mesh = mesh.into();
        let material = Material {
            base_color: Vec3::from(color).extend(1.0),
            ..Material::plain("lambert")
        };
        self.0.objects.push(Object {
            name: name.to_owned(),
            bounds: mesh.bounds(&transform),
            mesh,
            material: Arc::new(material),
            transform,
        });
        self
    }

    /// Light along `direction` (of any length), the stronger the lower it stands, so that level ground
    /// keeps some of its brightness.
    pub(super) fn sun(&mut self, direction: DVec3) -> &mut Self {
        let direction = unit(direction);
        let slant = direction.y.abs().clamp(0.01, 1.0);
        let color = Vec3::new(1.0, 0.93, 0.82) * (2.2 / slant.powf(0.8)) as f32;
        self.shine(LightKind::Directional { direction }, color)
    }

    /// A lamp at `position` towards `target`, its cone `angle` degrees from the axis to the rim; it lights
    /// what lies at the target as a sun would.
    pub(super) fn spot(
        &mut self,
        position: DVec3,
        target: DVec3,
        angle: f64,
        range: f64,
    ) -> &mut Self {
        let kind = LightKind::Spot {
            position,
            direction: unit(target - position),
            inner_angle: (0.85 * angle).to_radians(),
            outer_angle: angle.to_radians(),
            range,
        };
        self.shine(kind, lamp(position.distance(target)))
    }

    /// A lamp at `position` that lights what lies `reach` metres away as a sun would.
    pub(super) fn point(&mut self, position: DVec3, reach: f64, range: f64) -> &mut Self {
        self.shine(LightKind::Point { position, range }, lamp(reach))
    }

    fn shine(&mut self, kind: LightKind, color: Vec3) -> &mut Self {
        let kind_name = match kind {
            LightKind::Directional { .. } => "sun",
            LightKind::Spot { .. } => "spot",
            LightKind::Point { .. } => "lamp",
        };
        self.0.lights.push(SceneLight {
            name: format!("{kind_name} {}", self.0.lights.len()),
            light: Light { kind, color },
            cookie: None,
            shadow: None,
        });
        self
    }

    /// Nothing that stands here so far casts.
    pub(super) fn without_casters(&mut self) -> &mut Self {
        for object in &mut self.0.objects {
            Arc::make_mut(&mut object.material).casts = false;
        }
        self
    }

    /// The same, `by` metres away.
    pub(super) fn moved(&self, by: DVec3) -> Self {
        self.placed(1.0, by)
    }

    /// The same, `by` times as large, about the origin.
    pub(super) fn scaled(&self, by: f64) -> Self {
        self.placed(by, DVec3::ZERO)
    }

    fn placed(&self, scale: f64, offset: DVec3) -> Self {
        let mut scene = self.0.clone();
        let move_to = |place: DVec3| scale * place + offset;
        for object in &mut scene.objects {
            object.transform.matrix3 *= scale;
            object.transform.translation = move_to(object.transform.translation);
            object.bounds = object.mesh.bounds(&object.transform);
        }
        for SceneLight { light, .. } in &mut scene.lights {
            match &mut light.kind {
                LightKind::Directional { .. } => continue,
                LightKind::Spot {
                    position, range, ..
                }
                | LightKind::Point { position, range } => {
                    *position = move_to(*position);
                    *range *= scale;
                }
            }
            // Light thins with the square of the distance.
            light.color *= (scale * scale) as f32;
        }
        let camera = &mut scene.camera;
        camera.position = move_to(camera.position);
        camera.near *= scale;
        camera.far *= scale;
        Self(scene)
    }

    pub(super) fn case(&self, name: &'static str, hard: &'static str) -> Case {
        Case {
            name,
            hard,
            scene: self.0.clone(),
            axes: BTreeMap::new(),
            settings: BTreeMap::new(),
            frames: Vec::new(),
            same_as: None,
            size: (256, 144),
        }
    }
}

/// Divided, so that straight down is exactly that; glam multiplies by the rounded reciprocal.
fn unit(direction: DVec3) -> DVec3 {
    direction / direction.length()
}

/// Radiant intensity that gives about a sun's irradiance at `distance` metres.
fn lamp(distance: f64) -> Vec3 {
    Vec3::new(1.0, 0.86, 0.66) * (3.0 * distance * distance) as f32
}

/// A camera at `eye` that looks at `target`, `degrees` high; near 0.1 m, far 200 m.
pub(super) fn camera(eye: DVec3, target: DVec3, degrees: f64) -> Camera {
    Camera {
        position: eye,
        rotation: look_along(target - eye).unwrap_or_default(),
        field: Field::Perspective {
            fov_y: degrees.to_radians(),
        },
        near: 0.1,
        far: 200.0,
    }
}

pub(super) fn vec(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

pub(super) fn at(x: f64, y: f64, z: f64) -> DAffine3 {
    DAffine3::from_translation(vec(x, y, z))
}

/// At `place`, turned by degrees about the y axis, after a tilt about the x axis.
pub(super) fn turned(place: DVec3, turn: f64, tilt: f64) -> DAffine3 {
    let turn = DQuat::from_rotation_y(turn.to_radians());
    let tilt = DQuat::from_rotation_x(tilt.to_radians());
    DAffine3::from_rotation_translation(turn * tilt, place)
}

/// Places that look random and are the same each time: the golden ratio's and its plastic cousin's
/// multiples, from 0 to 1 on both axes (Roberts 2018, "The Unreasonable Effectiveness of Quasirandom
/// Sequences").
pub(super) fn scattered(count: u32) -> impl Iterator<Item = DVec2> {
    const PLASTIC: f64 = 1.324_717_957_244_746;
    (0..count).map(|index| {
        let step = f64::from(index) + 1.0;
        DVec2::new(step / PLASTIC, step / (PLASTIC * PLASTIC)).fract()
    })
}

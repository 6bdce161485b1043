//! A model without a scene: it gets a ground that fits it, and a camera and a sun where the model brings no camera
//! or no lights.

use std::{path::Path, sync::Arc};

use glam::{DAffine3, DVec3, Vec2, Vec3, Vec4};
use umbrage_shadow::{Aabb, Field, Light, LightKind, look_along};

use super::{
    Camera, LeftOut, Material, Mesh, Object, Scene, SceneError, SceneLight, Shadow, Staging,
    model::{self, Eye},
    own_lights::{BRIGHT, own_lights},
};

/// How far below a model its ground lies, as a share of the radius: a quarter of a pixel in the picture of 720 rows that
/// its camera takes, and hundreds of times what f32 depths and positions are off there. So a floor of the model's own
/// hides the ground under it, instead of fighting with it for each pixel.
const SUNK: f64 = 1e-3;
/// How long a ground's sides are, in radii.
const GROUND: f64 = 12.0;

/// Loads the model at `path`, with a ground and a sun where `staging` asks for them.
pub(super) fn load(path: &Path, staging: Staging) -> Result<Scene, SceneError> {
    let model = model::load(path, false)?;
    let mut objects = Vec::new();
    for part in model.parts {
        let object = Object::place(part.name, part.mesh, part.material, part.transform);
        let remedy = "mend the model and export it again";
        objects
            .push(object.map_err(|problem| SceneError::invalid(path, "nodes", problem, remedy))?);
    }
    let bounds = objects.iter().fold(
        Aabb {
            min: DVec3::INFINITY,
            max: DVec3::NEG_INFINITY,
        },
        |all, object| Aabb {
            min: all.min.min(object.bounds.min),
            max: all.max.max(object.bounds.max),
        },
    );
    let centre = 0.5 * (bounds.min + bounds.max);
    let radius = 0.5 * (bounds.max - bounds.min).length();
    if radius <= 0.0 {
        let remedy = "give a model that has an extent";
        return Err(SceneError::invalid(
            path,
            "scene",
            "all its points are one",
            remedy,
        ));
    }
    let lights = match model.lamps.is_empty() {
        true => staging.sun.then(sun).into_iter().collect(),
        false => own_lights(model.lamps, &objects),
    };
    let own = own_camera(&model.eyes, &bounds, radius);
    let camera = own.unwrap_or_else(|| camera(centre, radius));
    let others = model.eyes.len().saturating_sub(1);
    let others = LeftOut::new(path, "cameras", others, "the first camera looks");
    let level = DVec3::new(centre.x, bounds.min.y - SUNK * radius, centre.z);
    // From below, a ground would hide the model.
    if staging.ground && camera.position.y > level.y {
        objects.push(ground(path, level, radius)?);
    }
    Ok(Scene {
        objects,
        lights,
        camera,
        ambient: Vec3::splat(0.35),
        background: Vec3::new(0.3, 0.4, 0.6),
        medium: None,
        left_out: model.left_out.into_iter().chain(others).collect(),
    })
}

/// The first camera that a model with these bounds brings.
fn own_camera(eyes: &[Eye], bounds: &Aabb, radius: f64) -> Option<Camera> {
    let eye = eyes.first()?;
    let away = [bounds.min, bounds.max].map(|corner| (corner - eye.position).abs());
    let farthest = away[0].max(away[1]).length() + GROUND * radius;
    Some(Camera {
        position: eye.position,
        rotation: eye.rotation,
        field: eye.field,
        near: eye.near,
        // Without an end it sees all that there is.
        far: eye.far.unwrap_or(2.0 * farthest.max(eye.near)),
    })
}

fn ground(path: &Path, middle: DVec3, radius: f64) -> Result<Object, SceneError> {
    let mesh = Mesh::plane(Vec2::ONE, Vec2::ONE);
    let material = Material {
        base_color: Vec4::new(0.45, 0.45, 0.45, 1.0),
        ..Material::plain("lambert")
    };
    let transform = DAffine3::from_scale_rotation_translation(
        DVec3::new(GROUND * radius, 1.0, GROUND * radius),
        glam::DQuat::IDENTITY,
        middle,
    );
    Object::place(
        "ground".to_owned(),
        Arc::new(mesh),
        Arc::new(material),
        transform,
    )
    .map_err(|problem| SceneError::invalid(path, "scene", problem, "scale the model down"))
}

fn sun() -> SceneLight {
    let direction = DVec3::new(-0.6, -1.0, -0.45).normalize();
    SceneLight {
        name: "sun".to_owned(),
        light: Light {
            kind: LightKind::Directional { direction },
            color: Vec3::splat(BRIGHT),
        },
        cookie: None,
        shadow: Some(Shadow {
            method: "basic".to_owned(),
            ..Shadow::default()
        }),
    }
}

fn camera(centre: DVec3, radius: f64) -> Camera {
    let towards = DVec3::new(-0.55, -0.45, -1.0).normalize();
    Camera {
        // At 40 degrees a sphere of this radius fills two thirds of the picture's height.
        position: centre - 3.9 * radius * towards,
        rotation: look_along(towards).unwrap_or_default(),
        field: Field::Perspective {
            fov_y: 40_f64.to_radians(),
        },
        near: 0.05 * radius,
        far: 40.0 * radius,
    }
}

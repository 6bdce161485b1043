//! A model without a scene: it gets a ground, a camera and a sun that fit it.

use std::{path::Path, sync::Arc};

use glam::{DAffine3, DVec3, Vec2, Vec3, Vec4};
use umbrage_shadow::{Aabb, Field, Light, LightKind};

use super::{
    Camera, Material, Mesh, Object, Scene, SceneError, SceneLight, Shadow, Staging,
    file::look_along, model,
};

/// How far below a model its ground lies, as a share of the radius: a quarter of a pixel in the picture of 720 rows that
/// its camera takes, and hundreds of times what f32 depths and positions are off there. So a floor of the model's own
/// hides the ground under it, instead of fighting with it for each pixel.
const SUNK: f64 = 1e-3;

/// Loads the model at `path`, with a ground and a sun where `staging` asks for them.
pub(super) fn load(path: &Path, staging: Staging) -> Result<Scene, SceneError> {
    let mut objects = Vec::new();
    for part in model::load(path)? {
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
    let camera = camera(centre, radius);
    let level = DVec3::new(centre.x, bounds.min.y - SUNK * radius, centre.z);
    // From below, a ground would hide the model.
    if staging.ground && camera.position.y > level.y {
        objects.push(ground(path, level, radius)?);
    }
    Ok(Scene {
        objects,
        lights: staging.sun.then(sun).into_iter().collect(),
        camera,
        ambient: Vec3::splat(0.35),
        background: Vec3::new(0.3, 0.4, 0.6),
        medium: None,
    })
}

fn ground(path: &Path, middle: DVec3, radius: f64) -> Result<Object, SceneError> {
    let mesh = Mesh::plane(Vec2::ONE, Vec2::ONE);
    let material = Material {
        base_color: Vec4::new(0.45, 0.45, 0.45, 1.0),
        ..Material::plain("lambert")
    };
    let transform = DAffine3::from_scale_rotation_translation(
        DVec3::new(12.0 * radius, 1.0, 12.0 * radius),
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
            color: Vec3::splat(3.0),
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

//! Scenes of which the air is all that is seen.
#![allow(dead_code, reason = "each test program uses its own part")]

use glam::{DVec2, DVec3};
use umbrage_render::{Medium, Picture, RenderOptions, Rendered, Scene};

use super::scene;

pub(crate) const SIZE: (u32, u32) = (24, 18);

pub(crate) fn options(shaft_steps: u32) -> RenderOptions {
    RenderOptions {
        width: SIZE.0,
        height: SIZE.1,
        shaft_steps,
        fresh: true,
        ..RenderOptions::default()
    }
}

/// Black walls without a sky: what is seen is the air alone. The camera is askew, far from the origin.
pub(crate) fn black_room(light: &str, walls: &str) -> Scene {
    let mut scene = scene(&format!(
        r#"(
        camera: (position: (0.4, 1.2, 3), target: (-0.3, 1, -1), fov_degrees: 70, near: 0.2, far: 60),
        lights: [(name: "light", kind: {light}, color: (1, 0.5, 0.25), intensity: 3)],
        models: [(shape: plane(size: (40, 40)), material: (base_color: (0, 0, 0))), {walls}],
        )"#
    ));
    scene.medium = Some(Medium {
        scattering: 0.05,
        absorption: 0.03,
        anisotropy: 0.6,
    });
    scene
}

pub(crate) const SUN: &str = "directional(direction: (0.3, -1, -0.2))";
pub(crate) const LAMP: &str = "point(position: (-0.4, 1.5, 0.5), range: 6)";
pub(crate) const SPOT: &str = "spot(position: (-1.4, 2.5, 0.5), target: (0.2, 0, -1), inner_degrees: 15, outer_degrees: 25, range: 6)";

pub(crate) fn shaded(rendered: &Rendered) -> &[[f32; 3]] {
    match &rendered.picture {
        Picture::Shaded(pixels) => pixels,
        _ => unreachable!("a shaded picture was asked for"),
    }
}

/// A pixel's ray.
pub(crate) struct Sight {
    pub(crate) direction: DVec3,
    /// Metres.
    pub(crate) begin: f64,
    pub(crate) end: f64,
}

/// Sights of a scene whose only surface is the ground, one a pixel.
pub(crate) fn sights(scene: &Scene) -> impl Iterator<Item = Sight> {
    let view = scene.view(SIZE.0, SIZE.1);
    (0..SIZE.0 * SIZE.1).map(move |pixel| {
        let at = DVec2::new(f64::from(pixel % SIZE.0), f64::from(pixel / SIZE.0)) + 0.5;
        let slope = 0.5 * view.projection.size_at(1.0).y;
        let ndc = at / DVec2::new(SIZE.0.into(), SIZE.1.into()) * 2.0 - 1.0;
        let ray = DVec3::new(ndc.x * slope * view.projection.aspect, -ndc.y * slope, -1.0);
        let ray = view.rotation * ray;
        let ground = -view.position.y / ray.y;
        let hit = (view.position + ray * ground).abs().max_element() < 20.0;
        let seen = if ground > 0.0 && hit {
            ground
        } else {
            view.projection.far
        };
        Sight {
            direction: ray.normalize(),
            begin: view.projection.near * ray.length(),
            end: seen * ray.length(),
        }
    })
}

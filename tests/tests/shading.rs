//! Surfaces and lights give the radiance that their formulas say: each is drawn without shadows, and every
//! pixel held against the formulas on the CPU, in f64.
#![allow(
    clippy::panic,
    reason = "a test's helpers may fail it, with the error's own words"
)]

use std::{f64::consts::PI, sync::Arc};

use glam::DVec3;
use umbrage::{
    compose::{Composer, Target},
    render::{Gpu, Picture, RenderOptions, Renderer},
    shadow::{Light, LightKind},
};
use umbrage_tests::{Oracle, stage};

const SIZE: u32 = 48;

/// The direction to the light, and the irradiance of what faces it (KHR_lights_punctual's attenuation).
fn illuminate(light: &Light, position: DVec3) -> (DVec3, f64) {
    let intensity = f64::from(light.color.x);
    let near = |source: DVec3, range: f64| {
        let offset = source - position;
        let distance = offset.length();
        let window = (1.0 - (distance / range).powi(4)).clamp(0.0, 1.0);
        (
            offset / distance,
            intensity * window / (distance * distance),
        )
    };
    match light.kind {
        LightKind::Directional { direction } => (-direction, intensity),
        LightKind::Point { position, range } => near(position, range),
        LightKind::Spot {
            position,
            direction,
            inner_angle,
            outer_angle,
            range,
        } => {
            let (to_light, irradiance) = near(position, range);
            let (outer, inner) = (outer_angle.cos(), inner_angle.cos());
            let t = ((-to_light.dot(direction) - outer) / (inner - outer)).clamp(0.0, 1.0);
            (to_light, irradiance * t * t * (3.0 - 2.0 * t))
        }
    }
}

/// Lambert's law.
fn lambert(color: DVec3, normal: DVec3, to_light: DVec3, _: DVec3) -> DVec3 {
    color * (normal.dot(to_light).max(0.0) / PI)
}

/// glTF 2.0's appendix B for a dielectric of roughness 0.6.
fn ggx(color: DVec3, normal: DVec3, to_light: DVec3, to_viewer: DVec3) -> DVec3 {
    let (n_l, n_v) = (normal.dot(to_light), normal.dot(to_viewer));
    if n_l <= 0.0 {
        return DVec3::ZERO;
    }
    let half = (to_light + to_viewer).normalize();
    let (n_h, v_h) = (normal.dot(half), to_viewer.dot(half));
    let a2 = 0.6f64.powi(4);
    let d = a2 / (PI * (n_h * n_h * (a2 - 1.0) + 1.0).powi(2));
    let smith = |a: f64, b: f64| a * (b * b * (1.0 - a2) + a2).sqrt();
    let v = 0.5 / (smith(n_l, n_v) + smith(n_v, n_l));
    let f = 0.04 + 0.96 * (1.0 - v_h).powi(5);
    (color * ((1.0 - f) / PI) + f * d * v) * n_l
}

type Reflectance = fn(DVec3, DVec3, DVec3, DVec3) -> DVec3;

#[test]
fn radiance_is_what_the_formulas_say() {
    let library = umbrage::shader_library().expect("the shader library is sound");
    let composer = Arc::new(Composer::new(library.clone(), Target::webgpu()));
    let registry = || umbrage::methods::registry().expect("names are unique");
    let gpu = Gpu::new().unwrap_or_else(|error| panic!("{error}"));
    let mut renderer = Renderer::new(Arc::new(gpu), composer, registry());
    let surfaces: [(&str, Reflectance); 2] = [("lambert", lambert), ("ggx", ggx)];
    for (surface, reflectance) in surfaces {
        for light in ["directional", "spot", "point"] {
            let choices = [
                ("pass", "illumination"),
                ("surface", surface),
                ("light", light),
            ];
            let key = library
                .key(choices)
                .unwrap_or_else(|error| panic!("{error}"));
            let mut stage = stage(&library, &key, 64);
            let ambient = DVec3::new(0.1, 0.2, 0.3);
            stage.scene.ambient = ambient.as_vec3();
            let options = RenderOptions {
                width: SIZE,
                height: SIZE,
                ..RenderOptions::default()
            };
            let rendered = renderer
                .render(&stage.scene, &options)
                .unwrap_or_else(|error| panic!("{error}"));
            let Picture::Shaded(pixels) = rendered.picture else {
                panic!("a shaded picture was asked for")
            };
            let oracle = Oracle::new(&stage, &registry(), SIZE, SIZE).expect("no method is needed");
            let mut source = stage.scene.lights[0].light.clone();
            let eye = stage.scene.camera.position;
            match &mut source.kind {
                LightKind::Spot { position, .. } | LightKind::Point { position, .. } => {
                    *position -= eye
                }
                LightKind::Directional { .. } => {}
            }
            let (color, mut compared) = (DVec3::new(0.8, 0.7, 0.6), 0);
            for index in 0..SIZE * SIZE {
                let Ok((position, normal)) =
                    oracle.receiver(index % SIZE, index / SIZE, SIZE, SIZE)
                else {
                    continue;
                };
                let (to_light, irradiance) = illuminate(&source, position);
                let lit = reflectance(color, normal, to_light, -position.normalize()) * irradiance;
                let expected = lit + color * ambient;
                let found = DVec3::from(pixels[index as usize].map(f64::from));
                // Two additions in half floats, of 11 bits each.
                let allowed = 2e-3 * expected.max_element() + 1e-4;
                assert!(
                    (found - expected).abs().max_element() < allowed,
                    "{surface} under {light} at pixel {index}: {found} instead of {expected}"
                );
                compared += 1;
            }
            assert!(
                compared > SIZE * SIZE / 2,
                "only {compared} pixels were compared"
            );
        }
    }
}

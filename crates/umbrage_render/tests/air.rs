//! The air of a scene with a medium dims and scatters as closed forms say.

mod common;

use std::f64::consts::PI;

use common::{
    air::{LAMP, SPOT, SUN, Sight, black_room, options, shaded, sights},
    methods, renderer, scene,
};
use glam::DVec3;
use umbrage_render::{Medium, Rendered, Scene, Shadow};
use umbrage_shadow::{Light, LightKind};

/// Relative error of a half and of the sums of a shader's f32.
const ROUNDING: f64 = 1.0 / 1024.0;

/// Henyey and Greenstein's phase function.
fn phase(g: f64, cosine: f64) -> f64 {
    (1.0 - g * g) / (4.0 * PI * (1.0 + g * g - 2.0 * g * cosine).powf(1.5))
}

/// Compares each pixel's colour with what `expected` says of white light, and how far off it may be.
fn compare(scene: &Scene, rendered: &Rendered, expected: impl Fn(&Sight) -> (f64, f64)) {
    let mut brightest = 0.0_f64;
    for (pixel, (sight, color)) in sights(scene).zip(shaded(rendered)).enumerate() {
        let (radiance, bound) = expected(&sight);
        brightest = brightest.max(radiance);
        for (channel, light) in color.iter().zip([1.0, 0.5, 0.25]) {
            let off = (f64::from(*channel) - light * radiance).abs();
            let allowed = light * bound + ROUNDING * light * radiance + 1e-6;
            assert!(
                off <= allowed,
                "pixel {pixel}: {color:?}, not {radiance} by {bound}"
            );
        }
    }
    assert!(brightest > 1e-3, "nothing to compare");
}

/// A sun's light that nothing keeps off: ∫ σs p E exp(−σt t) dt has a closed form, whatever the steps.
#[test]
fn a_sun_without_shadows_is_its_integral() {
    let mut scene = black_room(SUN, "");
    let mut renderer = renderer(methods());
    let media = [
        (0.05, 0.03, 0.6),
        (0.2, 0.0, -0.8),
        (1e-5, 0.0, 0.0),
        (40.0, 5.0, 0.95),
    ];
    for (scattering, absorption, anisotropy) in media {
        for steps in [1, 7, 64] {
            scene.medium = Some(Medium {
                scattering,
                absorption,
                anisotropy,
            });
            let LightKind::Directional { direction } = scene.lights[0].light.kind else {
                unreachable!("it is a sun")
            };
            let extinction = scattering + absorption;
            // Thin air scatters little: brighter light for a half to hold.
            scene.lights[0].light.color =
                glam::Vec3::new(1.0, 0.5, 0.25) * (10.0 / scattering as f32);
            let rendered = renderer.render(&scene, &options(steps)).expect("renders");
            compare(&scene, &rendered, |sight| {
                let cosine = sight.direction.dot(-direction);
                let lost = -(extinction * (sight.begin - sight.end)).exp_m1();
                (10.0 * phase(anisotropy, cosine) * lost / extinction, 0.0)
            });
        }
    }
}

/// Dimming of a lamp's light at `point`, in a medium of `extinction`, and where the light comes from.
fn lamp_light(light: &Light, extinction: f64, point: DVec3) -> (f64, DVec3) {
    let (position, range, cone) = match light.kind {
        LightKind::Point { position, range } => (position, range, None),
        LightKind::Spot {
            position,
            range,
            direction,
            inner_angle,
            outer_angle,
        } => (position, range, Some((direction, inner_angle, outer_angle))),
        LightKind::Directional { .. } => unreachable!("it is a lamp"),
    };
    let offset = position - point;
    let distance = offset.length();
    let mut light = (1.0 - (distance / range).powi(4)).clamp(0.0, 1.0) / (distance * distance);
    if let Some((direction, inner, outer)) = cone {
        let cosine = -offset.dot(direction) / distance;
        let share = ((cosine - outer.cos()) / (inner.cos() - outer.cos())).clamp(0.0, 1.0);
        light *= share * share * (3.0 - 2.0 * share);
    }
    (light * (-extinction * distance).exp(), offset / distance)
}

/// Lamps that nothing keeps off are what a fine sum along the ray says. A sum with one term in each of N equal shares is
/// off its integral by no more than the integrand's variation over N (Koksma 1942).
#[test]
fn a_lamp_without_shadows_is_its_integral() {
    const FINE: usize = 20_000;
    let mut renderer = renderer(methods());
    for kind in [LAMP, SPOT] {
        let scene = black_room(kind, "");
        let light = &scene.lights[0].light;
        let (LightKind::Point { position, .. } | LightKind::Spot { position, .. }) = light.kind
        else {
            unreachable!("it is a lamp")
        };
        for steps in [16, 64, 1024] {
            let rendered = renderer.render(&scene, &options(steps)).expect("renders");
            compare(&scene, &rendered, |sight| {
                // At equal angles about the light, over what the ray has in its range.
                let offset = position - scene.camera.position;
                let middle = offset.dot(sight.direction);
                let apart = (offset - middle * sight.direction).length();
                let [from, to] = [sight.begin, sight.end].map(|t| ((t - middle) / apart).atan());
                let value = |share: f64| {
                    let along = apart * (from + (to - from) * share).tan();
                    let metres = (to - from) * (apart * apart + along * along) / apart;
                    let t = middle + along;
                    let point = scene.camera.position + t * sight.direction;
                    let (light, to_light) = lamp_light(light, 0.08, point);
                    let scattered = 0.05 * phase(0.6, to_light.dot(sight.direction));
                    3.0 * metres * light * scattered * (-0.08 * (t - sight.begin)).exp()
                };
                let values: Vec<_> = (0..FINE)
                    .map(|i| value((i as f64 + 0.5) / FINE as f64))
                    .collect();
                let sum: f64 = values.iter().sum();
                let varied: f64 = values
                    .windows(2)
                    .map(|pair| (pair[1] - pair[0]).abs())
                    .sum();
                (sum / FINE as f64, varied / f64::from(steps))
            });
        }
    }
}

/// The air dims what is seen by the whole ray; ambient light is the surface's alone.
#[test]
fn what_is_seen_is_dimmed() {
    let mut scene = scene(
        r#"(
        camera: (position: (0.4, 1.2, 3), target: (-0.3, 1, -1), fov_degrees: 70, near: 0.2, far: 60),
        ambient: (1, 0.5, 0.25),
        background: (1, 0.5, 0.25),
        models: [(shape: plane(size: (40, 40)))],
        )"#,
    );
    for (scattering, absorption) in [(0.0, 0.08), (0.03, 0.05)] {
        scene.medium = Some(Medium {
            scattering,
            absorption,
            anisotropy: 0.0,
        });
        let rendered = renderer(methods())
            .render(&scene, &options(1))
            .expect("renders");
        assert_eq!(rendered.report.passes, 2, "no light, no shafts");
        compare(&scene, &rendered, |sight| {
            ((0.08 * (sight.begin - sight.end)).exp(), 0.0)
        });
    }
}

/// The light that reaches a surface is dimmed by the air as well, but for a sun's.
#[test]
fn lamps_are_dimmed_on_their_way() {
    let mut renderer = renderer(methods());
    for (kind, lamp) in [(SUN, false), (LAMP, true), (SPOT, true)] {
        let mut scene = black_room(kind, "");
        let mut material = (*scene.objects[0].material).clone();
        material.base_color = glam::Vec4::ONE;
        scene.objects[0].material = material.into();
        scene.medium = None;
        let clear = renderer.render(&scene, &options(1)).expect("renders");
        scene.medium = Some(Medium {
            scattering: 0.0,
            absorption: 0.2,
            anisotropy: 0.0,
        });
        let dimmed = renderer.render(&scene, &options(1)).expect("renders");
        let mut compared = 0;
        for ((sight, clear), dimmed) in sights(&scene).zip(shaded(&clear)).zip(shaded(&dimmed)) {
            let point = scene.camera.position + sight.end * sight.direction;
            let way = match scene.lights[0].light.kind {
                LightKind::Point { position, .. } | LightKind::Spot { position, .. } if lamp => {
                    position.distance(point)
                }
                _ => 0.0,
            };
            let expected = (-0.2 * (way + sight.end - sight.begin)).exp() * f64::from(clear[0]);
            compared += usize::from(clear[0] > 0.01);
            assert!((f64::from(dimmed[0]) - expected).abs() <= 2.0 * ROUNDING * expected + 1e-6);
        }
        assert!(compared > 20, "{kind}: {compared}");
    }
}

/// A slab under a sun that stands at the zenith shades an upright prism of air, which a level ray enters and leaves where
/// its sides are.
#[test]
fn a_slab_shades_a_prism_of_air() {
    for (method, texel) in [("basic", 40.0 / 2048.0), ("pssm", 40.0 / 1024.0)] {
        let slab = "(shape: box(size: (3, 0.1, 2)), translation: (0, 4, -4), material: (base_color: (0, 0, 0)))";
        let mut scene = black_room("directional(direction: (0, -1, 0))", slab);
        scene.lights[0].shadow = Some(Shadow {
            method: method.to_owned(),
            ..Shadow::default()
        });
        scene.camera.rotation = glam::DQuat::IDENTITY;
        let steps = 256;
        let rendered = renderer(methods())
            .render(&scene, &options(steps))
            .expect("renders");
        let shaded_rays = std::cell::Cell::new(0);
        let eye = scene.camera.position;
        // Between which metres a ray is within the box.
        let within = |sight: &Sight, low: DVec3, high: DVec3| {
            let [a, b] = [low, high].map(|corner| (corner - eye) / sight.direction);
            (a.min(b).max_element(), a.max(b).min_element())
        };
        compare(&scene, &rendered, |sight| {
            let (low, high) = (DVec3::new(-1.5, 3.95, -5.0), DVec3::new(1.5, 4.05, -3.0));
            let (hit, past) = within(sight, low, high);
            let end = if hit < past && hit > 0.0 {
                hit
            } else {
                sight.end
            };
            // Below the slab there is shadow.
            let (into, out) = within(sight, low.with_y(-1e9), high);
            let into = into.clamp(sight.begin, end);
            let out = out.clamp(into, end);
            let arrives = |from: f64, to: f64| {
                ((0.08 * (sight.begin - from)).exp() - (0.08 * (sight.begin - to)).exp()) / 0.08
            };
            let lit = arrives(sight.begin, into) + arrives(out, end);
            let scattered = 3.0 * 0.05 * phase(0.6, sight.direction.y);
            // Both ends lie within a share of the steps, and the filter blurs a side by two texels; a ray that runs
            // along a side is in its blur for long.
            let slope = sight
                .direction
                .x
                .abs()
                .min(sight.direction.z.abs())
                .max(1e-9);
            let blur = 2.0 * arrives(sight.begin, (sight.begin + 2.5 * texel / slope).min(end));
            let share = 2.0 * arrives(sight.begin, end) / f64::from(steps);
            shaded_rays.set(shaded_rays.get() + usize::from(out > into));
            (scattered * lit, scattered * (blur + share))
        });
        assert!(shaded_rays.get() > 40, "{method}: {shaded_rays:?}");
    }
}

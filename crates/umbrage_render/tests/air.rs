//! The air of a scene with a medium dims and scatters as closed forms say.

mod common;

use std::f64::consts::PI;

use common::{example, methods, renderer, scene};
use glam::{DVec2, DVec3};
use umbrage_render::{
    Medium, Path, Picture, RenderOptions, Rendered, Scene, SceneLight, Shadow, What,
};
use umbrage_shadow::{Light, LightKind};

const SIZE: (u32, u32) = (24, 18);

/// What a half and the sums of a shader's f32 leave of a number, relative.
const ROUNDING: f64 = 1.0 / 1024.0;

fn options(shaft_steps: u32) -> RenderOptions {
    RenderOptions {
        width: SIZE.0,
        height: SIZE.1,
        shaft_steps,
        ..RenderOptions::default()
    }
}

/// Black walls without a sky: what is seen is the air alone. The camera is askew, far from the origin.
fn black_room(light: &str, walls: &str) -> Scene {
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

const SUN: &str = "directional(direction: (0.3, -1, -0.2))";
const LAMP: &str = "point(position: (-0.4, 1.5, 0.5), range: 6)";
const SPOT: &str = "spot(position: (-1.4, 2.5, 0.5), target: (0.2, 0, -1), inner_degrees: 15, outer_degrees: 25, range: 6)";

fn shaded(rendered: &Rendered) -> &[[f32; 3]] {
    match &rendered.picture {
        Picture::Shaded(pixels) => pixels,
        _ => unreachable!("a shaded picture was asked for"),
    }
}

/// A pixel's ray.
struct Sight {
    direction: DVec3,
    /// Metres.
    begin: f64,
    end: f64,
}

/// What each pixel sees of a scene whose only surface is the ground.
fn sights(scene: &Scene) -> impl Iterator<Item = Sight> {
    let view = scene.camera.view(SIZE.0, SIZE.1);
    (0..SIZE.0 * SIZE.1).map(move |pixel| {
        let at = DVec2::new(f64::from(pixel % SIZE.0), f64::from(pixel / SIZE.0)) + 0.5;
        let slope = (0.5 * view.projection.fov_y).tan();
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

/// What a lamp's light at `point` is dimmed to, in a medium of `extinction`, and where it comes from.
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

/// Where there is no medium, or nothing in it, a picture is what it was, and takes nothing more.
#[test]
fn clear_air_costs_nothing() {
    let mut renderer = renderer(methods());
    for name in ["bunny_sun.ron", "suzanne_spot.ron", "room_point.ron"] {
        for path in [Path::Forward, Path::Mask] {
            let mut scene = example(name);
            let options = RenderOptions {
                path,
                ..options(64)
            };
            let clear = renderer.render(&scene, &options).expect("renders");
            scene.medium = Some(Medium {
                scattering: 0.0,
                absorption: 0.0,
                anisotropy: 0.5,
            });
            let nothing = renderer.render(&scene, &options).expect("renders");
            assert_eq!(clear.picture, nothing.picture, "{name}");
            let [a, b] = [&clear.report, &nothing.report];
            assert_eq!(
                (a.passes, a.draws, a.texels),
                (b.passes, b.draws, b.texels),
                "{name}"
            );
            assert_eq!(a.plans, b.plans, "{name}");
            let keys = |report: &umbrage_render::Report| -> Vec<_> {
                report
                    .permutations
                    .iter()
                    .map(|used| used.key.clone())
                    .collect()
            };
            assert_eq!(keys(a), keys(b), "{name}");
            assert!(
                keys(a)
                    .iter()
                    .all(|key| !key.to_string().contains("shafts"))
            );
            // And with it: one pass for the air, and one for each light's.
            scene.medium = Some(Medium {
                scattering: 0.1,
                absorption: 0.0,
                anisotropy: 0.5,
            });
            let hazy = renderer.render(&scene, &options).expect("renders");
            let lights = scene.lights.len() as u32;
            assert_eq!(hazy.report.passes, a.passes + 1 + lights, "{name}");
            assert_eq!(hazy.report.texels, a.texels, "{name}");
            // A sun reaches surfaces as before: its light is what arrives.
            if name == "bunny_sun.ron" {
                let new: Vec<_> = keys(&hazy.report);
                let new = new.iter().filter(|key| !keys(a).contains(key));
                let passes: Vec<_> = new.map(|key| key.get("pass")).collect();
                assert_eq!(passes, [Some("haze"), Some("shafts")]);
            }
        }
    }
}

/// Four taps a step, however wide a surface's filter is, and one for the depth.
#[test]
fn fetches_are_four_a_step() {
    let mut renderer = renderer(methods());
    let methods = [
        ("basic", SUN, 4.0),
        ("pssm", SUN, 4.0),
        ("basic", LAMP, 9.0),
        ("none", SUN, 0.0),
    ];
    for (method, light, taps) in methods {
        // Not seen, but what could shade all that is.
        let tower = "(shape: box(size: (1, 12, 1)), translation: (15, 6, 15))";
        let mut scene = black_room(light, tower);
        scene.lights[0].shadow = Some(Shadow {
            method: method.to_owned(),
            axes: [("pcf".to_owned(), "5".to_owned())]
                .into_iter()
                .filter(|_| method != "none")
                .collect(),
            ..Shadow::default()
        });
        let steps = 20;
        let mut options = RenderOptions {
            what: What::ShaftFetches,
            ..options(steps)
        };
        if method != "none" {
            options.axes.insert("pcf".to_owned(), "9".to_owned());
        }
        let rendered = renderer.render(&scene, &options).expect("renders");
        let Picture::Fetches(counts) = &rendered.picture else {
            unreachable!("fetches were asked for")
        };
        let most = taps * f64::from(steps) + 1.0;
        let (mut full, mut all) = (0, 0);
        for (count, sight) in counts[0].iter().zip(sights(&scene)) {
            assert!(f64::from(*count) <= most, "{count}");
            // Rays to the ground stay in the box around the scene, of which the map is.
            if light == SUN && sight.end < 59.0 {
                all += 1;
                full += usize::from(f64::from(*count) == most);
            }
        }
        if light == SUN {
            assert!(all > 100 && full == all, "{method}: {full} of {all}");
        } else {
            assert!(
                counts[0].iter().any(|count| f64::from(*count) == most),
                "{method}"
            );
        }
    }
}

/// Surfaces are shaded by the same maps, which have the air to hold as well.
#[test]
fn shadows_on_surfaces_stay_where_they_are() {
    let mut renderer = renderer(methods());
    for name in [
        "bunny_sun.ron",
        "suzanne_spot.ron",
        "room_point.ron",
        "avenue.ron",
    ] {
        let mut scene = example(name);
        let options = RenderOptions {
            width: 320,
            height: 240,
            what: What::ShadowTerm,
            ..RenderOptions::default()
        };
        let terms = |rendered: Rendered| match rendered.picture {
            Picture::ShadowTerm(terms) => terms.concat(),
            _ => unreachable!("shadow terms were asked for"),
        };
        let clear = terms(renderer.render(&scene, &options).expect("renders"));
        scene.medium = Some(Medium {
            scattering: 0.1,
            absorption: 0.0,
            anisotropy: 0.5,
        });
        let hazy = terms(renderer.render(&scene, &options).expect("renders"));
        let mean = clear
            .iter()
            .zip(&hazy)
            .map(|(a, b)| (a - b).abs())
            .sum::<f32>()
            / clear.len() as f32;
        eprintln!("{name}: {mean}");
        assert!(mean < 0.01, "{name}: {mean}");
    }
}

fn all_finite(rendered: &Rendered, what: &str) {
    for pixel in shaded(rendered) {
        assert!(
            pixel.iter().all(|c| c.is_finite() && *c >= 0.0),
            "{what}: {pixel:?}"
        );
    }
}

/// Numbers as large and as small as scenes allow give numbers.
#[test]
fn hard_scenes_are_drawn() {
    let mut renderer = renderer(methods());
    for light in [SUN, LAMP, SPOT] {
        let walls = "(shape: box(size: (1, 1, 1)), translation: (0, 1, -2))";
        let plain = black_room(light, walls);
        let draw = |renderer: &mut umbrage_render::Renderer, scene: &Scene, what: &str| {
            for size in [SIZE, (1, 1), (1, 40)] {
                for steps in [1, 64, 4096] {
                    let (width, height) = size;
                    let options = RenderOptions {
                        width,
                        height,
                        ..options(steps)
                    };
                    if steps < 4096 || size == (1, 1) {
                        let rendered = renderer.render(scene, &options).expect("renders");
                        all_finite(&rendered, &format!("{light} {what} {size:?} {steps}"));
                    }
                }
            }
        };
        let mut scenes = vec![("plain", plain.clone())];
        let mut change = |what, change: &dyn Fn(&mut Scene)| {
            let mut scene = plain.clone();
            scene.lights[0].shadow = Some(Shadow {
                method: "basic".to_owned(),
                ..Shadow::default()
            });
            change(&mut scene);
            scenes.push((what, scene));
        };
        change("in a caster", &|scene| {
            scene.camera.position = DVec3::new(0.0, 1.0, -2.0)
        });
        change("at the light", &|scene| {
            scene.camera.position = match scene.lights[0].light.kind {
                LightKind::Spot { position, .. } | LightKind::Point { position, .. } => position,
                LightKind::Directional { .. } => DVec3::splat(1e6),
            };
        });
        change("far", &|scene| {
            (scene.camera.near, scene.camera.far) = (1e-6, 1e12)
        });
        change("a mountain", &|scene| {
            (scene.camera.near, scene.camera.far) = (1e3, 1e3 + 1e-3)
        });
        for (scattering, absorption) in [(1e6, 0.0), (0.0, 1e6), (1e-30, 0.0), (1e-45, 1e-45)] {
            change("thick or thin", &|scene| {
                scene.medium = Some(Medium {
                    scattering,
                    absorption,
                    anisotropy: 0.95,
                });
            });
        }
        for (what, scene) in &scenes {
            draw(&mut renderer, scene, what);
        }
    }
}

/// Rays along a lamp's axis, and straight through a lamp.
#[test]
fn a_lamp_may_stand_in_the_picture() {
    let mut scene = black_room(LAMP, "");
    let eye = scene.camera.position;
    let ahead = eye + 3.0 * scene.camera.view(1, 1).forward();
    let direction = (eye - ahead).normalize();
    let mut renderer = renderer(methods());
    let spot = |direction| LightKind::Spot {
        position: ahead,
        direction,
        inner_angle: 0.01,
        outer_angle: 0.02,
        range: 10.0,
    };
    for kind in [
        LightKind::Point {
            position: ahead,
            range: 10.0,
        },
        spot(direction),
        spot(-direction),
    ] {
        scene.lights = vec![SceneLight {
            name: "lamp".to_owned(),
            light: Light {
                kind,
                color: glam::Vec3::splat(0.1),
            },
            cookie: None,
            shadow: None,
        }];
        let one = RenderOptions {
            width: 1,
            height: 1,
            ..options(64)
        };
        let rendered = renderer.render(&scene, &one).expect("renders");
        all_finite(&rendered, "through");
        assert!(shaded(&rendered)[0][0] > 0.0);
    }
}

#[test]
fn steps_and_media_out_of_range_are_refused() {
    let mut scene = black_room(SUN, "");
    let mut renderer = renderer(methods());
    for steps in [0, 4097, u32::MAX] {
        let error = renderer
            .render(&scene, &options(steps))
            .expect_err("refused");
        assert_eq!(
            error.to_string(),
            format!(
                "{steps} steps along a ray through the medium cannot be made; choose from 1 to 4096"
            )
        );
    }
    scene.medium = Some(Medium {
        scattering: f64::NAN,
        absorption: 0.0,
        anisotropy: 0.0,
    });
    let error = renderer.render(&scene, &options(8)).expect_err("refused");
    assert_eq!(
        error.to_string(),
        "the medium: scattering is NaN, but must be from 0 to 1e6; change it in the scene"
    );
}

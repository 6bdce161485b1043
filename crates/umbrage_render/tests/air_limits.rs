//! Costs of a scene's air, and limits on what may be asked of it.

mod common;

use common::{
    air::{LAMP, SIZE, SPOT, SUN, black_room, options, shaded, sights},
    example, methods, renderer,
};
use glam::DVec3;
use umbrage_render::{
    Medium, Path, Picture, RenderOptions, Rendered, Scene, SceneLight, Shadow, What,
};
use umbrage_shadow::{Light, LightKind};

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
            options.shadow.axes.insert("pcf".to_owned(), "9".to_owned());
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

//! The mask path draws what the forward path draws.

mod common;

use common::{example, methods, pixel, renderer, small};
use glam::{DVec3, Vec3};
use umbrage_render::{
    Gpu, Path, Picture, RenderOptions, Rendered, Renderer, Scene, SceneLight, Shadow, What,
};
use umbrage_shadow::{Light, LightKind};

const SCENES: [&str; 4] = [
    "bunny_sun.ron",
    "leaves.ron",
    "room_point.ron",
    "suzanne_spot.ron",
];

/// How far the two paths' terms may be apart. The mask path's position lies on the ray through the
/// pixel's middle; the rasteriser's own is up to its grid beside it, 1/256 pixel on most devices. Over a
/// texel a filter of width W changes by 1 / W at the most, so where a pixel is about as wide as a texel,
/// as in these pictures, it comes to 1 / (256 W). A device that blends a fetch by weights of 8 bits may
/// give a step of these.
const STEP: f32 = 1.0 / 256.0;

/// The share of terms for which a comparison may fall the other way: where a receiver leaves a map, or
/// lies within the grid's width of the depth that it is compared with.
const DECISIONS: f64 = 1e-4;

fn options(what: What, path: Path) -> RenderOptions {
    RenderOptions {
        width: 480,
        height: 360,
        what,
        path,
        ..RenderOptions::default()
    }
}

/// The pictures of both paths.
fn both(renderer: &mut Renderer, scene: &Scene, options: &RenderOptions) -> [Rendered; 2] {
    [Path::Forward, Path::Mask].map(|path| {
        let options = RenderOptions {
            path,
            ..options.clone()
        };
        renderer.render(scene, &options).expect("renders")
    })
}

fn assert_alike(what: &str, pictures: [Rendered; 2]) {
    let [forward, mask] = pictures.map(|rendered| match rendered.picture {
        Picture::ShadowTerm(lights) => lights.concat(),
        _ => unreachable!("shadow terms were asked for"),
    });
    assert_eq!(forward.len(), mask.len());
    // Without penumbras nothing would be compared that could be off.
    let between = forward.iter().filter(|t| **t > 0.0 && **t < 1.0).count();
    assert!(between > 200, "{what}: {between} between 0 and 1");
    let pairs = forward.iter().zip(&mask);
    // NaN is apart.
    let near = pairs.filter(|(a, b)| (*a - *b).abs() <= STEP).count();
    let apart = forward.len() - near;
    let most = DECISIONS * forward.len() as f64;
    assert!(
        apart as f64 <= most,
        "{what}: {apart} of {} apart",
        forward.len()
    );
}

/// Every kind of light over leaves, and sky: the lamp reaches one leaf's corner.
fn all_lights() -> Scene {
    let mut scene = example("leaves.ron");
    let shadow = scene.lights[0].shadow.clone();
    let eye = scene.camera.position;
    let forward = scene.camera.view(4, 3).forward();
    let at = eye + forward * (0.6 * eye.length());
    let lamp = |name: &str, kind, strength: f32| SceneLight {
        name: name.to_owned(),
        light: Light {
            kind,
            color: Vec3::splat(strength),
        },
        cookie: None,
        shadow: shadow.clone().map(|shadow| Shadow {
            settings: [("resolution".to_owned(), 512.0)].into(),
            ..shadow
        }),
    };
    let position = at + DVec3::new(0.4, 1.6, 0.2);
    scene.lights.push(lamp(
        "spot",
        LightKind::Spot {
            position,
            direction: (DVec3::ZERO - position).normalize(),
            inner_angle: 0.3,
            outer_angle: 0.6,
            range: 20.0,
        },
        12.0,
    ));
    let near = LightKind::Point {
        position: DVec3::new(0.6, 0.5, 0.8),
        range: 1.5,
    };
    scene.lights.push(lamp("lamp", near, 2.0));
    scene
}

#[test]
fn masks_hold_the_terms_of_the_forward_path() {
    let mut renderer = renderer(methods());
    let options = options(What::ShadowTerm, Path::Mask);
    for name in SCENES {
        assert_alike(name, both(&mut renderer, &example(name), &options));
    }
    assert_alike("all lights", both(&mut renderer, &all_lights(), &options));
    for (axis, value) in [("pcf", "1"), ("pcf", "9"), ("receiver_bias", "constant")] {
        let mut options = options.clone();
        options
            .shadow
            .axes
            .insert(axis.to_owned(), value.to_owned());
        let what = format!("{axis} {value}");
        assert_alike(&what, both(&mut renderer, &all_lights(), &options));
    }
}

/// A thousand kilometres out, positions are found again as well as at the origin.
#[test]
fn masks_hold_the_terms_far_from_the_origin() {
    let mut scene = all_lights();
    let away = DVec3::new(1e6, -2e5, 3e5);
    scene.camera.position += away;
    for object in &mut scene.objects {
        object.transform.translation += away;
        object.bounds = object.mesh.bounds(&object.transform);
    }
    for light in &mut scene.lights {
        match &mut light.light.kind {
            LightKind::Spot { position, .. } | LightKind::Point { position, .. } => {
                *position += away;
            }
            LightKind::Directional { .. } => {}
        }
    }
    let options = options(What::ShadowTerm, Path::Mask);
    let pictures = both(&mut renderer(methods()), &scene, &options);
    assert_alike("far away", pictures);
}

/// Light adds up to the same: apart by no more than a step of the term, in the light that there would be
/// without shadow, and a rounding to half floats (11 bits) for each light.
#[test]
fn masked_pictures_are_the_forward_paths() {
    let mut renderer = renderer(methods());
    let colors = |rendered: Rendered| match rendered.picture {
        Picture::Shaded(pixels) => pixels,
        _ => unreachable!("a shaded picture was asked for"),
    };
    let scenes = SCENES.map(|name| (name, example(name)));
    for (name, scene) in scenes.into_iter().chain([("all lights", all_lights())]) {
        let shaded = options(What::Shaded, Path::Mask);
        let pictures = both(&mut renderer, &scene, &shaded);
        assert_ne!(pictures[0].picture, Picture::Shaded(Vec::new()));
        let [forward, mask] = pictures.map(colors);
        let none = RenderOptions {
            shadow: Shadow::new("none"),
            ..shaded
        };
        let unshadowed = colors(renderer.render(&scene, &none).expect("renders"));
        let lights = scene.lights.len() as f32;
        let apart = |pixel: &usize| {
            let channels = 0..3;
            !channels.into_iter().all(|channel| {
                let lit = unshadowed[*pixel][channel];
                let off = (forward[*pixel][channel] - mask[*pixel][channel]).abs();
                off <= lit * (STEP + lights / 1024.0)
            })
        };
        let count = (0..forward.len()).filter(apart).count();
        let most = DECISIONS * forward.len() as f64;
        assert!(count as f64 <= most, "{name}: {count} pixels are apart");
        let dark = forward.iter().zip(&unshadowed);
        let dark = dark.filter(|(a, b)| a[1] < 0.9 * b[1]).count();
        assert!(dark > 1000, "{name}: {dark} pixels in shadow");
    }
}

#[test]
fn only_lights_that_need_a_mask_take_one() {
    let mut scene = all_lights();
    scene.lights[1].shadow = None;
    let mut renderer = renderer(methods());
    let shaded = RenderOptions {
        path: Path::Mask,
        timed: true,
        ..small(What::Shaded)
    };
    let mut report = |scene: &Scene, options: &RenderOptions| {
        renderer.render(scene, options).expect("renders").report
    };
    let mask = report(&scene, &shaded);
    let forward = report(
        &scene,
        &RenderOptions {
            path: Path::Forward,
            ..shaded.clone()
        },
    );
    // Planes, and a mask for each light but the spot, which has no method.
    assert_eq!(mask.passes, forward.passes + 3);
    let pixels = 160 * 120;
    assert_eq!((mask.mask_bytes, forward.mask_bytes), (20 * pixels, 0));
    // Everything seen once more, and a triangle a mask.
    assert_eq!(mask.draws, forward.draws + 2 + scene.objects.len() as u32);
    if Gpu::new().expect("an adapter").has_timestamps() {
        let mut passes: Vec<_> = mask.times.iter().map(|time| time.pass.as_str()).collect();
        passes.dedup();
        let expected = [
            "base",
            "casters",
            "linear_depth",
            "mask",
            "illumination",
            "casters",
            "mask",
            "illumination",
        ];
        assert_eq!(passes, expected);
        let of = |pass: &str| mask.times.iter().filter(|time| time.pass == pass).count();
        assert_eq!(
            (of("mask"), of("linear_depth"), of("illumination")),
            (2, 1, 3)
        );
    }
    // A surface's shader knows no method any more, and each method one mask.
    let keys: Vec<_> = mask.permutations.iter().map(|used| &used.key).collect();
    for key in &keys {
        let method = key.get("method");
        match key.get("pass") {
            Some("mask") => {
                assert_eq!(method, Some("basic"), "{key}");
                assert_eq!(key.get("base_color_texture"), None, "{key}");
            }
            _ => assert!(matches!(method, None | Some("mask")), "{key}"),
        }
    }
    // Where no light has a method, nothing is laid down.
    let none = RenderOptions {
        shadow: Shadow::new("none"),
        ..shaded
    };
    let unshadowed = report(&scene, &none);
    assert_eq!(unshadowed.mask_bytes, 0);
    assert_eq!(unshadowed.passes, 4);
}

/// The ground lies in the shadow of what the lamp reaches, but beyond the lamp's range: it is lit in
/// both, as no light asks for its term.
#[test]
fn what_no_light_reaches_keeps_its_term() {
    let mut renderer = renderer(methods());
    for (range, expected) in [(2.9, 1.0), (5.0, 0.0)] {
        let scene = common::scene(&format!(
            r#"(
            camera: (position: (0, 1, 6), target: (0, 1, 0)),
            lights: [(
                kind: spot(position: (0, 3, 0), target: (0, 0, 0), outer_degrees: 40, range: {range}),
                shadow: (method: "basic"),
            )],
            models: [
                (shape: plane(size: (8, 8))),
                (shape: box(size: (0.5, 0.5, 0.5)), translation: (0, 1, 0)),
            ])"#,
        ));
        for rendered in both(&mut renderer, &scene, &small(What::ShadowTerm)) {
            let floor = pixel(&scene, &rendered, DVec3::new(0.2, 0.0, 0.2));
            let Picture::ShadowTerm(lights) = &rendered.picture else {
                unreachable!("shadow terms were asked for")
            };
            assert_eq!(lights[0][floor], expected, "{range} m");
        }
    }
}

/// One mask serves all lights, and planes are laid down once: what one light leaves is not the next
/// one's.
#[test]
fn each_light_has_a_mask_of_its_own() {
    let scene = all_lights();
    let options = options(What::ShadowTerm, Path::Mask);
    let mut renderer = renderer(methods());
    let together = renderer.render(&scene, &options).expect("renders");
    let Picture::ShadowTerm(together) = together.picture else {
        unreachable!("shadow terms were asked for")
    };
    for (light, term) in scene.lights.iter().zip(&together) {
        let mut alone = scene.clone();
        alone.lights = vec![light.clone()];
        let alone = renderer.render(&alone, &options).expect("renders");
        let expected = Picture::ShadowTerm(vec![term.clone()]);
        assert!(alone.picture == expected, "{}", light.name);
        assert!(term.iter().any(|term| *term < 0.5), "{}", light.name);
    }
}

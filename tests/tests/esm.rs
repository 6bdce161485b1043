//! What exponential shadow maps are known for, on a device and against closed forms: they are percentage-closer filtering
//! where all occluders lie in front of the receiver, they leak at contacts, and two kinds of scenes break them.
//!
//! The scenes are level sheets, seen from below, under a light from straight above: a sheet's height is its distance.
#![allow(
    clippy::panic,
    reason = "a test's helpers may fail it, with the error's own words"
)]

use std::{collections::BTreeMap, sync::Arc};

use glam::{DAffine3, DQuat, DVec2, DVec3, Vec2, Vec3, Vec4};
use umbrage::{
    compose::{Composer, Target},
    render::{
        Camera, Gpu, Material, Mesh, Object, Picture, RenderOptions, Renderer, Scene, SceneLight,
        Shadow, What,
    },
    shadow::{Light, LightKind, Pass, ShadowPlan, Value},
};

/// Pixels along the pictures.
const SIZE: u32 = 128;

/// Texels along the maps.
const RESOLUTION: f64 = 512.0;

const FILTERS: [&str; 3] = ["esm", "esm_half", "esm_log"];

/// Half the angle that the camera sees, as a tangent.
const SPREAD: f64 = 0.5;

/// A level rectangle: from and to, x and z, and its height; metres.
#[derive(Clone, Copy)]
struct Sheet {
    min: DVec2,
    max: DVec2,
    height: f64,
}

fn sheet(half: f64, height: f64) -> Sheet {
    Sheet {
        min: DVec2::splat(-half),
        max: DVec2::splat(half),
        height,
    }
}

/// What a scene is drawn with.
struct Choice {
    filter: &'static str,
    width: u32,
    /// 0: chosen by the method.
    exponent: f64,
}

/// Terms, and where each was taken: x and z.
struct Drawn {
    terms: Vec<f64>,
    places: Vec<DVec2>,
    plan: ShadowPlan,
}

impl Drawn {
    /// The terms at places that `wanted` picks, 10 at the least.
    fn at(&self, wanted: impl Fn(DVec2) -> bool) -> Vec<(DVec2, f64)> {
        let all = self.places.iter().copied().zip(self.terms.iter().copied());
        let found: Vec<_> = all.filter(|(place, _)| wanted(*place)).collect();
        assert!(found.len() >= 10, "{} pixels", found.len());
        found
    }

    /// The range of distances that the map holds, metres, and the wider side of its texels.
    fn range(&self) -> (f64, f64) {
        let Some(Pass::Casters(pass)) = self.plan.passes.first() else {
            panic!("no casters' pass");
        };
        let to_world = pass.view_proj.as_dmat4().inverse();
        let step = |axis: DVec3| to_world.transform_vector3(axis).length();
        let texel = 2.0 * step(DVec3::X).max(step(DVec3::Y)) / RESOLUTION;
        (step(DVec3::Z), texel)
    }

    /// What a receiver's depth is raised by, as a share of the range.
    fn bias(&self) -> f64 {
        match self.plan.constants.get("bias") {
            Some(Value::Vec2(bias)) => bias.x.into(),
            _ => panic!("no bias"),
        }
    }

    /// The exponent of the first map.
    fn exponent(&self) -> f64 {
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

struct Studio(Renderer);

impl Studio {
    fn new() -> Self {
        let gpu = Arc::new(Gpu::new().unwrap_or_else(|error| panic!("{error}")));
        let library = umbrage::shader_library().expect("the shader library is sound");
        let composer = Arc::new(Composer::new(library, Target::webgpu()));
        let registry = umbrage::methods::registry().expect("names are unique");
        Self(Renderer::new(gpu, composer, registry))
    }

    /// The first sheet as seen from the height `eye`, straight up.
    fn draw(&mut self, sheets: &[Sheet], eye: f64, choice: &Choice) -> Drawn {
        self.draw_sheet(sheets, (eye, sheets[0].height), choice)
    }

    /// The same; places are where it sees the height `seen`.
    fn draw_sheet(&mut self, sheets: &[Sheet], (eye, seen): (f64, f64), choice: &Choice) -> Drawn {
        let scene = scene(sheets, eye, choice);
        let options = RenderOptions {
            width: SIZE,
            height: SIZE,
            what: What::ShadowTerm,
            ..RenderOptions::default()
        };
        let rendered = self.0.render(&scene, &options);
        let rendered = rendered.unwrap_or_else(|error| panic!("{error}"));
        let Picture::ShadowTerm(terms) = rendered.picture else {
            panic!("a shadow term was asked for");
        };
        let place = |pixel: u32| {
            let at = |number: u32| 2.0 * (f64::from(number) + 0.5) / f64::from(SIZE) - 1.0;
            // The camera's right is x; what it has for up is z.
            let across = DVec2::new(at(pixel % SIZE), -at(pixel / SIZE));
            across * SPREAD * (seen - eye)
        };
        Drawn {
            terms: terms[0].iter().map(|term| f64::from(*term)).collect(),
            places: (0..SIZE * SIZE).map(place).collect(),
            plan: rendered.report.plans[0].clone().expect("a plan"),
        }
    }
}

fn scene(sheets: &[Sheet], eye: f64, choice: &Choice) -> Scene {
    let objects = sheets.iter().map(|sheet| {
        let size = (sheet.max - sheet.min).as_vec2();
        let middle = 0.5 * (sheet.min + sheet.max);
        let transform = DAffine3::from_translation(DVec3::new(middle.x, sheet.height, middle.y));
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
        ("resolution".to_owned(), RESOLUTION),
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
                    direction: DVec3::NEG_Y,
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
            fov_y: 2.0 * SPREAD.atan(),
            near: 0.05,
            far: 100.0,
        },
        ambient: Vec3::ZERO,
        background: Vec3::ZERO,
        medium: None,
    }
}

/// What rounding may do to a term, relative. Positions, depths and exponentials of f32 differ by a few units in the last of 24
/// bits, which the exponent multiplies; each of the two maps and the fetch may round to 11 bits in halves.
fn rounding(filter: &str, exponent: f64) -> f64 {
    let halves = if filter == "esm_half" {
        3.0 / 2048.0
    } else {
        0.0
    };
    exponent * 16.0 / 16_777_216.0 + 1e-4 + halves
}

/// Deep in the shadow of a sheet g of the range above it, a receiver has exp(−k (g − b)) of the light, for every width:
/// 1 % of it where the gap is 4.6 / k.
#[test]
fn contacts_leak_as_far_as_the_formula_says() {
    let mut studio = Studio::new();
    let top = 20.0;
    for filter in FILTERS {
        let exponent = if filter == "esm_half" { 18.0 } else { 90.0 };
        for gap in [0.02, 0.1, 0.5, 1.02, 2.0, 5.1] {
            // A small sheet far above the view's edge sets the range.
            let roof = Sheet {
                min: DVec2::splat(4.7),
                max: DVec2::splat(4.9),
                height: top,
            };
            let sheets = [sheet(5.0, 0.0), sheet(2.0, gap), roof];
            let choice = Choice {
                filter,
                width: 15,
                exponent,
            };
            let drawn = studio.draw(&sheets, -9.0, &choice);
            let (range, _) = drawn.range();
            assert!((range - top).abs() < 0.1, "{range}");
            let far = gap / range - drawn.bias();
            let expected = (-exponent * far).exp().min(1.0);
            let bound = rounding(filter, exponent);
            for (place, term) in drawn.at(|at| at.abs().max_element() < 1.5) {
                let off = (term / expected - 1.0).abs();
                assert!(
                    off <= bound,
                    "{filter}, {gap} m, {place}: {term}, not {expected}"
                );
            }
            let dark = far > 4.605_17 / exponent;
            assert_eq!(expected < 0.01, dark, "4.6 / k is where 1 % is left");
            for (place, term) in drawn.at(|at| (2.5..4.0).contains(&at.abs().max_element())) {
                assert!(
                    term >= 1.0 - bound,
                    "{filter}, {place}: {term} in the light"
                );
            }
        }
    }
}

/// A lattice of strips, all of them in front of the floor.
fn strips() -> Vec<Sheet> {
    let mut sheets = vec![sheet(5.0, 0.0)];
    for number in 0..7 {
        let x = -3.9 + 1.1 * f64::from(number);
        sheets.push(Sheet {
            min: DVec2::new(x, -4.0),
            max: DVec2::new(x + 0.2 + 0.05 * f64::from(number), 4.0),
            height: 3.0 + 0.5 * f64::from(number),
        });
    }
    for number in 0..5 {
        let z = -3.0 + 1.4 * f64::from(number);
        sheets.push(Sheet {
            min: DVec2::new(-4.0, z),
            max: DVec2::new(4.0, z + 0.15 + 0.1 * f64::from(number)),
            height: 2.5 + 0.3 * f64::from(number),
        });
    }
    sheets
}

/// Salvi's claim. Of a window of which the share L is lit, percentage-closer filtering gives L, and an exponential map L exp(k b) and what
/// leaks through the rest, (1 − L) exp(−k (g − b)) for the nearest gap g, no more than 1 of both: so the two differ by
/// exp(k b) − 1 or by exp(−k (g − b)) at the most, and never to the dark side.
#[test]
fn it_is_percentage_closer_filtering_where_all_occluders_are_in_front() {
    let mut studio = Studio::new();
    let sheets = strips();
    for width in [3, 7, 15] {
        let choice = |filter, exponent| Choice {
            filter,
            width,
            exponent,
        };
        let pcf = studio.draw(&sheets, -9.0, &choice("pcf", 0.0));
        let partly = pcf.terms.iter().filter(|term| (0.1..0.9).contains(*term));
        assert!(
            partly.count() > 300 * width as usize / 3,
            "edges of some width"
        );
        for (filter, exponent) in [("esm", 150.0), ("esm_half", 19.0), ("esm_log", 2000.0)] {
            let esm = studio.draw(&sheets, -9.0, &choice(filter, exponent));
            let (range, _) = esm.range();
            let raised = (exponent * esm.bias()).exp_m1();
            let leak = (-exponent * (2.5 / range - esm.bias())).exp();
            // Weights of 8 bits, in two fetches on one side and one on the other.
            let bound = rounding(filter, exponent) + 1.5 / 256.0;
            let mut worst = 0.0_f64;
            for ((pcf, esm), place) in pcf.terms.iter().zip(&esm.terms).zip(&esm.places) {
                let above = esm - pcf;
                worst = worst.max(above.abs());
                let most = (raised * pcf + leak * (1.0 - pcf)).min(1.0 - pcf);
                assert!(
                    (-bound..=most + bound).contains(&above),
                    "{filter} {width}, {place}: {esm}, but {pcf} by comparison; {leak}, {raised}"
                );
            }
            println!(
                "{filter} of {width}: {worst:.4} off, of {:.4}",
                leak.max(raised) + bound
            );
        }
    }
}

/// Where a window reaches past a receiver's edge to what lies behind it, the share that does is multiplied by exp(k g): a
/// table in full shadow is lit along its edge, half as far in as the filter is wide.
#[test]
fn a_receiver_that_is_not_the_farthest_is_lit_along_its_edge() {
    let mut studio = Studio::new();
    // The floor begins beside the table, which is seen past it and sets the range.
    let floor = Sheet {
        min: DVec2::new(1.6, -5.0),
        max: DVec2::new(5.0, 5.0),
        height: 0.0,
    };
    let sheets = [floor, sheet(1.0, 2.0), sheet(1.0, 4.0)];
    for filter in FILTERS {
        let choice = |filter| Choice {
            filter,
            width: 15,
            exponent: 19.0,
        };
        let esm = studio.draw_sheet(&sheets, (-4.0, 2.0), &choice(filter));
        let pcf = studio.draw_sheet(&sheets, (-4.0, 2.0), &choice("pcf"));
        let (_, texel) = esm.range();
        let half = 7.5 * texel;
        let inside = |from: f64, to: f64| {
            move |at: DVec2| at.y.abs() < 0.5 && (from..to).contains(&(1.0 - at.x.abs()))
        };
        let near = inside(0.0, half - 1.5 * texel);
        for ((place, esm), (_, pcf)) in esm.at(near).into_iter().zip(pcf.at(near)) {
            assert!(
                esm > 0.999 && pcf < 0.55,
                "{filter}, {place}: {esm}, {pcf} by comparison"
            );
        }
        let deep = inside(half + 1.5 * texel, 1.0);
        for ((place, esm), (_, pcf)) in esm.at(deep).into_iter().zip(pcf.at(deep)) {
            assert!(
                esm < 0.01 && pcf == 0.0,
                "{filter}, {place}: {esm}, {pcf} by comparison"
            );
        }
    }
}

/// Of two occluders above one another the map holds the upper one alone. Beside it the lower one leaks as its own gap
/// says; over the upper one's edge, which shades nothing, that leak fades by the filter's width.
#[test]
fn of_two_overlapping_occluders_the_lower_one_leaks() {
    let mut studio = Studio::new();
    let upper = Sheet {
        max: DVec2::new(0.0, 3.0),
        ..sheet(3.0, 3.0)
    };
    let sheets = [sheet(5.0, 0.0), sheet(3.0, 0.3), upper];
    for filter in FILTERS {
        let choice = |filter| Choice {
            filter,
            width: 15,
            exponent: 12.0,
        };
        let esm = studio.draw(&sheets, -9.0, &choice(filter));
        let pcf = studio.draw(&sheets, -9.0, &choice("pcf"));
        let (range, texel) = esm.range();
        let left = |gap: f64| (-12.0 * (gap / range - esm.bias())).exp();
        let (lower, upper) = (left(0.3), left(3.0));
        assert!(lower > 0.25 && upper < 1e-4, "{lower}, {upper}");
        let shaded = |at: DVec2| at.abs().max_element() < 2.0;
        for ((place, esm), (_, pcf)) in esm.at(shaded).into_iter().zip(pcf.at(shaded)) {
            assert_eq!(pcf, 0.0, "{place} is in full shadow");
            let share = (0.5 + place.x / (15.0 * texel)).clamp(0.0, 1.0);
            let expected = share * lower + (1.0 - share) * upper;
            // The edge is at a whole texel of the map.
            let bound = lower * (1.0 / 15.0 + rounding(filter, 12.0));
            assert!(
                (esm - expected).abs() < bound,
                "{filter}, {place}: {esm}, not {expected}"
            );
        }
    }
}

/// With the largest exponents that the formats hold, from one end of the range to the other: the nearest surface and the
/// farthest are lit, nothing is out of range or no number, and a shadow is as dark as the exponent says.
#[test]
fn the_largest_exponents_neither_overflow_nor_vanish() {
    let mut studio = Studio::new();
    let top = 6.0;
    // Seen from below: the floor beside the roof, then the roof past the floor.
    let floor = Sheet {
        min: DVec2::new(0.5, -2.0),
        max: DVec2::new(4.0, 2.0),
        height: 0.0,
    };
    let roof = Sheet {
        min: DVec2::new(-4.0, -2.0),
        max: DVec2::new(1.5, 2.0),
        height: top,
    };
    for (filter, exponent) in [("esm", 163.5), ("esm_half", 19.4), ("esm_log", 65536.0)] {
        for width in [1, 3, 15] {
            let choice = Choice {
                filter,
                width,
                exponent,
            };
            let bound = rounding(filter, exponent);
            let low = studio.draw_sheet(&[floor, roof], (-8.0, 0.0), &choice);
            assert!(low.terms.iter().all(|term| (0.0..=1.0).contains(term)));
            let (_, texel) = low.range();
            let margin = 9.0 * texel;
            for (place, term) in low.at(|at| at.x > 1.5 + margin && at.x < 3.8 && at.y.abs() < 1.8)
            {
                assert!(
                    term >= 1.0 - bound,
                    "{filter} {width}, {place}: {term} on the floor"
                );
            }
            let dark = (-exponent * (1.0 - 0.01_f64)).exp() + 1e-30;
            for (place, term) in low.at(|at| at.x > 0.6 && at.x < 1.5 - margin && at.y.abs() < 1.8)
            {
                assert!(
                    term <= dark,
                    "{filter} {width}, {place}: {term} below the roof"
                );
            }
            let high = studio.draw_sheet(&[floor, roof], (-8.0, top), &choice);
            for (place, term) in high.at(|at| at.x < 0.0 && at.x > -3.8 && at.y.abs() < 1.8) {
                assert!(
                    term >= 1.0 - bound,
                    "{filter} {width}, {place}: {term} on the roof"
                );
            }
        }
    }
}

/// By default a hundredth of the light is left 2 (W + 1) texels below an occluder, where the format holds the exponent.
#[test]
fn the_default_leak_is_two_filters_long() {
    let mut studio = Studio::new();
    for (filter, width) in [
        ("esm", 15),
        ("esm_log", 3),
        ("esm_half", 3),
        ("esm_log", 15),
    ] {
        let choice = Choice {
            filter,
            width,
            exponent: 0.0,
        };
        let drawn = studio.draw(&[sheet(5.0, 0.0), sheet(1.0, 2.0)], -9.0, &choice);
        let (range, texel) = drawn.range();
        let reach = 2.0 * f64::from(width + 1) * texel / range;
        let left = (-drawn.exponent() * reach).exp();
        if filter == "esm_half" {
            assert!(
                (19.3..19.42).contains(&drawn.exponent()),
                "{}",
                drawn.exponent()
            );
        } else {
            assert!((left - 0.01).abs() < 1e-4, "{filter} {width}: {left}");
        }
    }
}

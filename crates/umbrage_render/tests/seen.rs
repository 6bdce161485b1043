//! A method that asks between which depths pixels see something is told so, in the same frame.

mod common;

use std::sync::{Arc, Mutex};

use common::{example, methods, renderer, scene};
use glam::{DVec2, DVec3};
use umbrage_methods::methods::pssm::{self, Pssm};
use umbrage_render::{Medium, Path, Picture, RenderOptions, Renderer, Report, Scene, Shadow, What};
use umbrage_shadow::{Frame, Light, Part, PlanError, Registry, ShadowMethod, ShadowPlan, Support};

type Seen = Arc<Mutex<Vec<Option<[f64; 2]>>>>;

/// Parallel splits, and a note of what they were told.
struct Noting(Seen);

impl Part for Noting {
    fn name(&self) -> &str {
        Pssm.name()
    }
    fn axes(&self) -> &[&str] {
        Pssm.axes()
    }
}

impl ShadowMethod for Noting {
    fn supports(&self, light: &Light) -> Support {
        Pssm.supports(light)
    }
    fn plan(&self, frame: &Frame<'_>) -> Result<ShadowPlan, PlanError> {
        self.0.lock().expect("a note").push(pssm::seen(frame)?);
        let settings = umbrage_shadow::Settings::check(Pssm.settings(), []).expect("defaults");
        Pssm.plan(&Frame {
            settings: &settings,
            ..*frame
        })
    }
}

fn noting() -> (Renderer, Seen) {
    let seen = Seen::default();
    let mut registry = Registry {
        methods: Registry::new().methods,
        ..methods()
    };
    registry
        .methods
        .add(Noting(Arc::clone(&seen)))
        .expect("the only one");
    (renderer(registry), seen)
}

fn options(what: What, [width, height]: [u32; 2], range: &str) -> RenderOptions {
    RenderOptions {
        width,
        height,
        what,
        shadow: Shadow::new("pssm").with("range", range),
        ..RenderOptions::default()
    }
}

/// The least and the greatest view depth by the triangles that the picture's pixels see, along the rays through their
/// middles.
fn reduced(renderer: &mut Renderer, scene: &Scene, size: [u32; 2]) -> [f64; 2] {
    let rendered = renderer
        .render(scene, &options(What::Triangles, size, "boxes"))
        .expect("renders");
    let Picture::Triangles(pixels) = rendered.picture else {
        unreachable!("triangles were asked for")
    };
    let view = scene.view(size[0], size[1]);
    let back = view.view_proj_relative().inverse();
    let depth = |(pixel, seen): (usize, &Option<(u32, u32)>)| {
        let (object, triangle) = (*seen)?;
        let object = &scene.objects[object as usize];
        let corners = object.mesh.indices.chunks_exact(3).nth(triangle as usize)?;
        let corner = |i: usize| {
            let local = object.mesh.positions[corners[i] as usize].as_dvec3();
            object.transform.transform_point3(local) - view.position
        };
        let normal = (corner(1) - corner(0)).cross(corner(2) - corner(0));
        let at = DVec2::new(
            (pixel as u32 % size[0]).into(),
            (pixel as u32 / size[0]).into(),
        ) + 0.5;
        let at = at / DVec2::new(size[0].into(), size[1].into());
        let ndc = DVec3::new(2.0 * at.x - 1.0, 1.0 - 2.0 * at.y, 0.5);
        let ray = back.project_point3(ndc);
        let hit = ray * (normal.dot(corner(0)) / normal.dot(ray));
        Some(hit.dot(view.forward()))
    };
    let depths = pixels.iter().enumerate().filter_map(depth);
    depths.fold([f64::MAX, 0.0], |[least, most], depth| {
        [least.min(depth), most.max(depth)]
    })
}

#[test]
fn the_depths_told_are_those_of_the_pixels() {
    let (mut renderer, seen) = noting();
    // One block, blocks cut by the edge, and whole ones.
    for size in [[40, 30], [97, 65], [320, 192]] {
        for name in ["avenue.ron", "leaves.ron", "bunny_sun.ron"] {
            let scene = example(name);
            let expected = reduced(&mut renderer, &scene, size);
            assert!(expected[1] > 1.5 * expected[0], "{name}: {expected:?}");
            for path in [Path::Forward, Path::MaskBySplit] {
                for what in [What::Shaded, What::ShadowTerm] {
                    let options = RenderOptions {
                        path,
                        ..options(what, size, "depths")
                    };
                    seen.lock().expect("a note").clear();
                    renderer.render(&scene, &options).expect("renders");
                    let told = seen.lock().expect("a note").clone();
                    let Some((Some([least, most]), asked)) = told.split_last() else {
                        unreachable!("one light asks and is told: {told:?}")
                    };
                    // Where the depth is not there yet, it is laid down once it is asked for.
                    let asks = if what == What::Shaded { 1 } else { 2 };
                    assert_eq!(asked, vec![None; asks]);
                    // A rasteriser's grid moves what is seen at grazing angles.
                    let apart = (least / expected[0] - 1.0).abs();
                    assert!(apart < 1e-3, "{name} {size:?}: {least} for {expected:?}");
                    let apart = (most / expected[1] - 1.0).abs();
                    assert!(apart < 1e-2, "{name} {size:?}: {most} for {expected:?}");
                }
            }
        }
    }
}

#[test]
fn who_does_not_ask_pays_nothing() {
    let (mut renderer, seen) = noting();
    let scene = example("avenue.ron");
    let size = [160, 120];
    let mut render = |range| {
        let options = options(What::Shaded, size, range);
        renderer.render(&scene, &options).expect("renders").report
    };
    let (boxes, depths) = (render("boxes"), render("depths"));
    // The reduction, over the depth that the picture has anyway; asked again, it stands.
    let others = |report: &Report| report.passes - report.caster_passes;
    assert_eq!(others(&depths), others(&boxes) + 1);
    assert_eq!((boxes.derived_passes, depths.derived_passes), (0, 1));
    assert_eq!((boxes.kept_passes, depths.kept_passes), (0, 1));
    assert_eq!((boxes.mask_bytes, depths.mask_bytes), (0, 0));
    let told = seen.lock().expect("a note").clone();
    assert!(
        matches!(told[..], [None, None, Some(_)]),
        "who does not ask plans once: {told:?}"
    );
}

/// Maps stand though the frame's plan begins with a question, and what is asked is found anew in each picture.
#[test]
fn maps_stand_between_questions() {
    let (mut renderer, seen) = noting();
    let mut scene = example("avenue.ron");
    scene.lights.push(scene.lights[0].clone());
    let options = options(What::Shaded, [160, 120], "depths");
    let first = renderer.render(&scene, &options).expect("renders").report;
    let second = renderer.render(&scene, &options).expect("renders").report;
    assert!(first.caster_passes > 2, "{}", first.caster_passes);
    // Each light asks for itself.
    assert_eq!((first.derived_passes, second.derived_passes), (2, 2));
    assert_eq!(second.caster_passes, 0);
    assert_eq!(second.kept_passes, first.caster_passes + 2);
    let told = seen.lock().expect("a note").clone();
    assert_eq!(told.len(), 8);
    assert!(told.iter().skip(1).step_by(2).all(|one| *one == told[1]));
}

/// Air is seen from the near plane on: where it is a receiver, boxes bound the range, and nothing is asked.
#[test]
fn air_is_bounded_by_boxes() {
    let (mut renderer, seen) = noting();
    let mut scene = example("avenue.ron");
    scene.medium = Some(Medium {
        scattering: 0.01,
        absorption: 0.0,
        anisotropy: 0.0,
    });
    let options = options(What::Shaded, [160, 120], "depths");
    let report = renderer.render(&scene, &options).expect("renders").report;
    assert_eq!(report.derived_passes, 0);
    assert_eq!(*seen.lock().expect("a note"), [None]);
}

/// A box may be in sight where no pixel sees what is in it, such as a plane from its edge: then no map is drawn.
#[test]
fn nothing_may_be_seen() {
    let scene = scene(
        r#"(
        camera: (position: (0, 0, 4), target: (0, 0, 0)),
        lights: [(kind: directional(direction: (0, -1, 0)))],
        models: [(shape: plane(size: (8, 8)))])"#,
    );
    let (mut renderer, seen) = noting();
    let options = options(What::Shaded, [64, 63], "depths");
    let rendered = renderer.render(&scene, &options).expect("renders");
    let told = seen.lock().expect("a note").clone();
    let [None, Some([least, most])] = told[..] else {
        unreachable!("one light asks and is told: {told:?}")
    };
    assert!(least > most, "{least} to {most} m");
    assert_eq!(rendered.report.caster_passes, 0);
}

/// Nearer bounds change where splits are, and no shadow by more than their texels do.
#[test]
fn terms_stay_what_they_are() {
    let (mut renderer, _) = noting();
    let mut scene = example("avenue.ron");
    scene.lights[0].shadow = Some(Shadow {
        method: "pssm".to_owned(),
        ..Shadow::default()
    });
    let [boxes, depths] = ["boxes", "depths"].map(|range| {
        let options = options(What::ShadowTerm, [240, 160], range);
        let rendered = renderer.render(&scene, &options).expect("renders");
        match rendered.picture {
            Picture::ShadowTerm(lights) => lights[0].clone(),
            _ => unreachable!("a shadow term was asked for"),
        }
    });
    let pairs = boxes.iter().zip(&depths);
    let apart = pairs.filter(|(a, b)| (*a - *b).abs() > 0.5).count();
    let dark = boxes.iter().filter(|term| **term < 0.5).count();
    assert!(
        dark > 1000 && apart < dark / 50,
        "{apart} apart, {dark} dark"
    );
}

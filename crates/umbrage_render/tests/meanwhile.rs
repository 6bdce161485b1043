//! Frames that go on while workers make their pipelines.

mod common;

use std::time::{Duration, Instant};

use common::{example, methods, renderer};
use umbrage_render::{Meanwhile, Picture, RenderOptions, Renderer, Scene, Shadow, StandIn, What};

/// A wide filter, and a narrow one in its place.
const WIDE: &str = "7";
const NARROW: &str = "3";
/// How far the narrow one's terms may be off, root mean square.
const ERROR: f64 = 0.05;

fn options(pcf: &str, what: What) -> RenderOptions {
    let shadow = Shadow::new("basic").with("pcf", pcf);
    RenderOptions {
        width: 96,
        height: 64,
        what,
        shadow: shadow.with_setting("resolution", 256.0),
        ..RenderOptions::default()
    }
}

fn narrow() -> StandIn {
    StandIn {
        axes: [("pcf".to_owned(), NARROW.to_owned())].into(),
        error: ERROR,
    }
}

fn picture(renderer: &mut Renderer, scene: &Scene, options: &RenderOptions) -> Picture {
    renderer.render(scene, options).expect("renders").picture
}

/// Pictures and reports until all is made that the first of them lacks.
fn until_made(
    renderer: &mut Renderer,
    scene: &Scene,
    options: &RenderOptions,
) -> Vec<umbrage_render::Rendered> {
    let start = Instant::now();
    let mut all = Vec::new();
    loop {
        let rendered = renderer.render(scene, options).expect("renders");
        let done = rendered.report.waiting == 0;
        all.push(rendered);
        if done {
            return all;
        }
        assert!(start.elapsed() < Duration::from_secs(120), "it hangs");
    }
}

#[test]
fn each_picture_is_the_wanted_one_or_the_stand_ins() {
    let scene = example("bunny_sun.ron");
    for what in [What::ShadowTerm, What::Shaded] {
        let wanted = picture(&mut renderer(methods()), &scene, &options(WIDE, what));
        let options = RenderOptions {
            meanwhile: Meanwhile::StandIn(narrow()),
            ..options(WIDE, what)
        };
        // By another renderer, of which nothing is made: the narrow filter on the maps, and with the bias, of the wide one.
        let stands_in = picture(&mut renderer(methods()), &scene, &options);
        assert!(wanted != stands_in, "the filters differ");
        let all = until_made(&mut renderer(methods()), &scene, &options);
        let (last, before) = all.split_last().expect("a picture");
        assert!(!before.is_empty(), "nothing is ready in the first picture");
        for rendered in before {
            assert!(rendered.picture == stands_in);
            assert_eq!(rendered.report.stand_in_error, ERROR);
        }
        assert!(last.picture == wanted);
        assert_eq!(last.report.stand_in_error, 0.0);
        if let (Picture::ShadowTerm(wanted), Picture::ShadowTerm(stands_in)) = (&wanted, &stands_in)
        {
            let terms = wanted.concat().into_iter().zip(stands_in.concat());
            let squares: Vec<_> = terms.map(|(a, b)| f64::from(a - b).powi(2)).collect();
            let rms = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
            assert!(rms <= ERROR, "{rms} is more than the stand-in states");
        }
    }
}

#[test]
fn a_light_that_is_skipped_adds_nothing() {
    let scene = example("bunny_sun.ron");
    let mut dark = scene.clone();
    dark.lights.clear();
    let wanted = options(WIDE, What::Shaded);
    let with = picture(&mut renderer(methods()), &scene, &wanted);
    let without = picture(&mut renderer(methods()), &dark, &wanted);
    let options = RenderOptions {
        meanwhile: Meanwhile::Skip,
        ..wanted
    };
    let all = until_made(&mut renderer(methods()), &scene, &options);
    let (last, before) = all.split_last().expect("a picture");
    assert!(!before.is_empty());
    assert!(before.iter().all(|rendered| rendered.picture == without));
    assert!(last.picture == with);
}

#[test]
fn a_stand_in_that_there_is_not_is_refused() {
    let mut stand_in = narrow();
    stand_in.axes.insert("pcf".to_owned(), "999".to_owned());
    let options = RenderOptions {
        meanwhile: Meanwhile::StandIn(stand_in),
        ..options(WIDE, What::Shaded)
    };
    let refused = renderer(methods()).render(&example("bunny_sun.ron"), &options);
    let said = refused.expect_err("no such value").to_string();
    assert!(said.contains("pcf") && said.contains("999"), "{said}");
}

//! Figures that a renderer tells for measuring: fetches, triangles, times, passes and bytes.

mod common;

use common::{example, methods, pixel, renderer, scene, small};
use glam::DVec3;
use umbrage_render::{
    Gpu, Picture, RenderOptions, Rendered, Renderer, Report, Scene, Shadow, What,
};
use umbrage_shadow::Pass;

const SPOT: &str = "spot(position: (0, 3, 0), target: (0, 0, 0), outer_degrees: 40, range: 20)";
const POINT: &str = "point(position: (0, 3, 0), range: 20)";
const SUN: &str = "directional(direction: (0.2, -1, 0.1))";

/// A ball over a ground that the sky is seen above, and a post that no lamp reaches.
fn lit_by(light: &str) -> Scene {
    scene(&format!(
        r#"(
        camera: (position: (0, 4, 9), target: (0, 1.5, 0), fov_degrees: 60),
        lights: [(kind: {light}, shadow: (method: "basic", settings: {{"resolution": 64}}))],
        models: [
            (shape: plane(size: (12, 12))),
            (shape: sphere(radius: 0.5), translation: (0, 1, 0)),
            (shape: box(size: (0.2, 0.2, 0.2)), translation: (30, 1, -40)),
        ])"#
    ))
}

fn with_width(what: What, width: u32) -> RenderOptions {
    let mut options = small(what);
    options
        .shadow
        .axes
        .insert("pcf".to_owned(), width.to_string());
    options
}

fn fetches(rendered: &Rendered) -> &[f32] {
    let Picture::Fetches(lights) = &rendered.picture else {
        unreachable!("fetches were asked for")
    };
    &lights[0]
}

#[test]
fn basic_fetches_what_its_width_says_and_where_its_map_is() {
    let mut renderer = renderer(methods());
    let below = DVec3::new(1.0, 0.0, 0.5);
    // Beyond 40° from the lamp's axis, and beyond the map's corner as well.
    let aside = DVec3::new(5.5, 0.0, 1.0);
    for width in [1_u32, 3, 5, 15] {
        // A bilinear fetch takes two of W + 1 columns and rows; a cube map's takes one direction.
        let flat = u32::pow(width.div_ceil(2), 2);
        let cube = width * width;
        for (light, inside, outside) in [(SUN, flat, flat), (SPOT, flat, 0), (POINT, cube, cube)] {
            let scene = lit_by(light);
            let rendered = renderer
                .render(&scene, &with_width(What::Fetches, width))
                .expect("renders");
            let counts = fetches(&rendered);
            let at = |point| counts[pixel(&scene, &rendered, point)];
            assert_eq!(at(below), inside as f32, "{light} {width}");
            assert_eq!(at(aside), outside as f32, "{light} {width}");
            // The picture's first row is sky.
            assert_eq!(counts[0], 0.0, "{light} {width}");
            let plan = rendered.report.plans[0].as_ref().expect("a plan");
            let most = counts.iter().copied().fold(0.0, f32::max);
            assert_eq!(most, plan.fetches_per_pixel as f32, "{light} {width}");
        }
    }
}

/// A surface that no light reaches takes no fetch, nor does a light without a method; and what a material fetches
/// for its holes is not counted.
#[test]
fn only_a_method_fetches() {
    let mut renderer = renderer(methods());
    let leaves = example("leaves.ron");
    let render = |renderer: &mut Renderer, options: &RenderOptions| {
        renderer.render(&leaves, options).expect("renders")
    };
    let mut options = small(What::Fetches);
    let rendered = render(&mut renderer, &options);
    let most = fetches(&rendered).iter().copied().fold(0.0, f32::max);
    let plan = rendered.report.plans[0].as_ref().expect("a plan");
    assert_eq!(most, plan.fetches_per_pixel as f32);
    options.shadow = Shadow::new("none");
    let rendered = render(&mut renderer, &options);
    assert!(fetches(&rendered).iter().all(|count| *count == 0.0));

    let mut away = lit_by("point(position: (0, 3, 0), range: 3.5)");
    let post = away.objects.len() - 1;
    away.objects[post].transform.translation = DVec3::new(3.0, 3.0, -3.0);
    away.objects[post].bounds = away.objects[post]
        .mesh
        .bounds(&away.objects[post].transform);
    let rendered = renderer
        .render(&away, &small(What::Fetches))
        .expect("renders");
    let at = |point| fetches(&rendered)[pixel(&away, &rendered, point)];
    assert_eq!(at(DVec3::new(3.0, 3.0, -2.9)), 0.0);
    assert_eq!(at(DVec3::new(0.0, 0.0, 2.0)), 9.0);
}

/// Objects of one mesh are drawn together, whatever stands between them in the scene.
#[test]
fn triangles_tell_an_object_by_its_place_in_the_scene() {
    let mut scene = scene(
        r#"(
        camera: (position: (0, 0, 9), target: (0, 0, 0)),
        lights: [],
        models: [
            (shape: box(size: (1, 1, 1)), translation: (-2, 0, 0)),
            (shape: sphere(radius: 0.5)),
        ])"#,
    );
    let mut third = scene.objects[0].clone();
    third.transform.translation.x = 2.0;
    third.bounds = third.mesh.bounds(&third.transform);
    scene.objects.push(third);
    let rendered = renderer(methods())
        .render(&scene, &small(What::Triangles))
        .expect("renders");
    let Picture::Triangles(seen) = &rendered.picture else {
        unreachable!("triangles were asked for")
    };
    let at = |x| seen[pixel(&scene, &rendered, DVec3::new(x, 0.1, 0.5))];
    let object = |x| at(x).map(|(object, _)| object);
    assert_eq!(
        [object(-2.0), object(0.0), object(2.0)],
        [Some(0), Some(1), Some(2)]
    );
    // The same face of the same mesh; and between them, nothing.
    let face = |x| at(x).map(|(_, triangle)| triangle);
    assert_eq!(face(-2.0), face(2.0));
    assert_eq!(at(1.1), None);
}

/// The bunny in the sun, in a picture that takes the device some time.
fn bunny(resolution: u32, width: u32) -> (Scene, RenderOptions) {
    let mut options = with_width(What::ShadowTerm, width);
    (options.width, options.height) = (480, 360);
    let resolution = f64::from(resolution);
    options
        .shadow
        .settings
        .insert("resolution".to_owned(), resolution);
    (example("bunny_sun.ron"), options)
}

/// The reports of a few timed runs: what else the machine does only adds to a time, so the least of each
/// kind is the best guess.
fn runs(renderer: &mut Renderer, scene: &Scene, options: &RenderOptions) -> Vec<Report> {
    let options = RenderOptions {
        timed: true,
        ..options.clone()
    };
    let render = |_| renderer.render(scene, &options).expect("renders").report;
    (0..8).map(render).collect()
}

fn least(runs: &[Report], time: impl Fn(&Report) -> f64) -> f64 {
    runs.iter().map(time).fold(f64::INFINITY, f64::min)
}

fn of_passes(report: &Report, pass: &str) -> f64 {
    let passes = report.times.iter().filter(|time| time.pass == pass);
    passes.map(|time| time.milliseconds).sum()
}

fn has_timestamps() -> bool {
    Gpu::new().expect("an adapter").has_timestamps()
}

#[test]
fn passes_are_timed_when_asked_and_in_their_order() {
    let mut scene = example("suzanne_spot.ron");
    let mut sun = example("bunny_sun.ron").lights.remove(0);
    sun.name = "evening sun".to_owned();
    scene.lights.push(sun);
    let mut renderer = renderer(methods());
    let mut render = |what, timed| {
        let options = RenderOptions {
            timed,
            ..small(what)
        };
        renderer.render(&scene, &options).expect("renders").report
    };
    let untimed = render(What::Shaded, false);
    assert!(untimed.times.is_empty());
    assert!(untimed.gpu_milliseconds > 0.0 && untimed.gpu_milliseconds < untimed.milliseconds);
    let passes = |report: Report| -> Vec<_> {
        let times = report.times.into_iter();
        times.map(|time| (time.pass, time.light)).collect()
    };
    let spot = scene.lights[0].name.clone();
    let evening = "evening sun".to_owned();
    let expected = |passes: &[(&str, Option<&String>)]| -> Vec<_> {
        let owned = passes.iter().filter(|_| has_timestamps());
        owned
            .map(|(pass, light)| ((*pass).to_owned(), light.cloned()))
            .collect()
    };
    let of_lights = |pass| {
        [
            ("casters", Some(&spot)),
            (pass, Some(&spot)),
            ("casters", Some(&evening)),
            (pass, Some(&evening)),
        ]
    };
    for (what, pass) in [
        (What::ShadowTerm, "shadow_term"),
        (What::Fetches, "fetch_count"),
    ] {
        assert_eq!(passes(render(what, true)), expected(&of_lights(pass)));
    }
    let shaded = [&[("base", None)][..], &of_lights("illumination")].concat();
    assert_eq!(passes(render(What::Shaded, true)), expected(&shaded));
    let triangles = [("triangle", None)];
    assert_eq!(passes(render(What::Triangles, true)), expected(&triangles));
}

/// The device's clock and ours agree: what the passes take is most of what we wait for, and no more.
#[test]
fn times_add_up_to_the_wait() {
    if !has_timestamps() {
        return;
    }
    let (scene, options) = bunny(512, 7);
    let runs = runs(&mut renderer(methods()), &scene, &options);
    let sum = |report: &Report| {
        report
            .times
            .iter()
            .map(|time| time.milliseconds)
            .sum::<f64>()
    };
    for report in &runs {
        // Passes that overlap would be counted twice; and our clock runs on around the device's.
        assert!(
            sum(report) <= 1.01 * report.gpu_milliseconds,
            "{:?} in {} ms",
            report.times,
            report.gpu_milliseconds
        );
    }
    let rest = least(&runs, |report| 1.0 - sum(report) / report.gpu_milliseconds);
    assert!(rest < 0.2, "{rest} of the wait is in no pass");
}

#[test]
fn times_grow_with_the_filter_and_the_map() {
    if !has_timestamps() {
        return;
    }
    let mut renderer = renderer(methods());
    let mut time = |resolution, width, pass| {
        let (scene, options) = bunny(resolution, width);
        least(&runs(&mut renderer, &scene, &options), |report| {
            of_passes(report, pass)
        })
    };
    // 64 fetches for one, and 64 times the texels: several times as long, whatever each costs.
    let (narrow, wide) = (time(256, 1, "shadow_term"), time(256, 15, "shadow_term"));
    assert!(wide > 2.0 * narrow, "{wide} ms for {narrow} ms");
    let (small, large) = (time(256, 1, "casters"), time(2048, 1, "casters"));
    assert!(large > 2.0 * small, "{large} ms for {small} ms");
}

#[test]
fn reports_tell_casters_and_bytes_apart() {
    let mut renderer = renderer(methods());
    let report = |renderer: &mut Renderer, light: &str, what| {
        let rendered = renderer.render(&lit_by(light), &small(what));
        rendered.expect("renders").report
    };
    // Reversed depth in 32 bits: four bytes a texel, six faces of a cube.
    for (light, layers) in [(SUN, 1), (SPOT, 1), (POINT, 6)] {
        let shaded = report(&mut renderer, light, What::Shaded);
        assert_eq!(shaded.texels, layers * 64 * 64, "{light}");
        assert_eq!(shaded.shadow_bytes, 4 * shaded.texels, "{light}");
        let plan = shaded.plans[0].as_ref().expect("a plan");
        assert_eq!(shaded.caster_passes as usize, plan.passes.len(), "{light}");
        // The base pass and the light's own.
        assert_eq!(shaded.passes, shaded.caster_passes + 2, "{light}");
        let drawn: usize = plan
            .passes
            .iter()
            .map(|pass| match pass {
                Pass::Casters(pass) => pass.casters.len(),
                _ => 0,
            })
            .sum();
        // No two objects of the scene share a mesh: each is a draw.
        assert_eq!(shaded.caster_draws as usize, drawn, "{light}");
        assert!(shaded.draws > shaded.caster_draws, "{light}");

        let triangles = report(&mut renderer, light, What::Triangles);
        assert_eq!((triangles.passes, triangles.caster_passes), (1, 0));
        assert_eq!((triangles.shadow_bytes, triangles.plans), (0, vec![None]));
    }
}

/// A moving camera makes nothing anew that it could keep.
#[test]
fn pictures_after_the_first_compose_nothing() {
    let mut scene = example("room_point.ron");
    let mut renderer = renderer(methods());
    for what in [
        What::Shaded,
        What::ShadowTerm,
        What::Triangles,
        What::Fetches,
    ] {
        let mut sources = Vec::new();
        for _ in 0..4 {
            scene.camera.position.x += 1e-3;
            let report = renderer
                .render(&scene, &small(what))
                .expect("renders")
                .report;
            sources.push(report.composed());
        }
        assert!(
            sources[0] > 0 && sources[1..] == [0, 0, 0],
            "{what:?}: {sources:?}"
        );
    }
}

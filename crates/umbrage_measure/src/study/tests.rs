//! Figures that the study puts together itself, against what they must come to.

use std::{path::Path, sync::Arc};

use umbrage_compose::{Composer, Library, RonFile, Target};
use umbrage_render::{Decision, Gpu, Picture, RenderOptions, Scene, Shadow, What};
use umbrage_shadow::{Frame, Light, Part, PlanError, ShadowMethod, ShadowPlan, Support};

use super::{
    CompareOptions, Config, Lab, compare,
    lab::{mean, pixels, terms},
    motion::cameras,
    stress,
    timing::baseline,
};
use crate::{
    cases::{self, Limits},
    report::Spread,
    truth::Truth,
};

const SIZE: (u32, u32) = (160, 90);

fn lab() -> Lab {
    let package = umbrage_shader_lib::package().expect("the shader library");
    let library = Library::new([package]).expect("the library");
    let composer = Arc::new(Composer::new(library, Target::default()));
    let methods = umbrage_methods::registry().expect("names are unique");
    Lab::new(Arc::new(Gpu::new().expect("an adapter")), composer, methods)
}

fn example(name: &str) -> Scene {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/scenes");
    Scene::load(folder.join(name)).expect("a sound scene")
}

/// With a method's own shadows in the truth's place, the picture that FLIP compares with must be the
/// picture that the renderer shades: they are put together in different places.
#[test]
fn lights_and_shadow_terms_add_up_to_the_shaded_picture() {
    let mut lab = lab();
    for name in ["bunny_sun.ron", "suzanne_spot.ron", "room_point.ron"] {
        let scene = example(name);
        let mut truth = Truth::trace(&scene, SIZE, &[], &|| ()).expect("traced");
        let options = RenderOptions {
            width: SIZE.0,
            height: SIZE.1,
            shadow: Shadow::new("basic"),
            ..RenderOptions::default()
        };
        let subject = lab.subject(&scene, &truth).expect("drawn");
        let rendered = lab.terms(&subject, &options).expect("drawn");
        let shaded = lab.render(&scene, &options).expect("drawn");
        let unshadowed = lab.unshadowed(&subject).expect("drawn");
        let own = terms(&rendered).iter();
        truth.terms = own.map(|t| t.iter().copied().map(Some).collect()).collect();
        let subject = lab.subject(&scene, &truth).expect("drawn");
        let added = subject.shaded_truth(&unshadowed);
        let drawn = pixels(&shaded.picture);
        assert_eq!(added.len(), drawn.len());
        for (pixel, (added, drawn)) in added.iter().zip(drawn).enumerate() {
            for (added, drawn) in added.iter().zip(drawn) {
                // The renderer adds up half floats, and each of the pictures is rounded to one.
                let off = (added - drawn).abs() / added.max(0.01);
                assert!(off < 4.0 / 1024.0, "{name}, pixel {pixel}: {added} {drawn}");
            }
        }
        // And FLIP sees no more than that rounding.
        let flip = subject.flip(&unshadowed, &shaded).expect("of one size");
        assert!(flip < 0.01, "{name}: {flip}");
    }
}

#[test]
fn a_motion_goes_aside_and_then_turns_by_less_than_a_pixel() {
    let scene = example("bunny_sun.ron");
    let truth = Truth::trace(&scene, SIZE, &[], &|| ()).expect("traced");
    let found = cameras(&scene, &truth.sight, SIZE.1, 9);
    assert_eq!(found.len(), 9);
    assert_eq!(found[0].position, scene.camera.position);
    let pixel = scene.view(SIZE.0, SIZE.1).projection.size_at(1.0).y / f64::from(SIZE.1);
    let mut kinds = Vec::new();
    for pair in found.windows(2) {
        let moved = pair[0].position.distance(pair[1].position);
        let turned = pair[0].rotation.angle_between(pair[1].rotation);
        assert!(
            (moved > 0.0) != (turned > 1e-9),
            "one of the two: {moved} {turned}"
        );
        assert!(turned < pixel && moved < pixel * scene.camera.far);
        kinds.push(moved > 0.0);
    }
    assert_eq!(kinds, [true, true, true, true, true, false, false, false]);
}

#[test]
fn what_is_standard_is_known_and_holds_the_baseline() {
    let lab = lab();
    let text = include_str!("../../configs.ron");
    let file = RonFile::new("configs.ron", text);
    let configs = Config::read(&file, lab.registry(), lab.library()).expect("sound");
    let standard = Config::standard(&["basic".to_owned()], lab.registry(), lab.library());
    let standard = standard.expect("sound");
    assert!(standard.len() > 5 && standard.iter().all(|config| configs.contains(config)));
    // And the dozen that the demo shows.
    let file = RonFile::new(
        "configs.ron",
        include_str!("../../../../examples/configs.ron"),
    );
    let dozen = Config::read(&file, lab.registry(), lab.library()).expect("sound");
    assert!(dozen.len() == 12 && dozen.iter().all(|config| configs.contains(config)));
    assert_eq!(baseline().shadow, Shadow::new("basic").with("pcf", "1"));
    assert!(Config::standard(&["none".to_owned()], lab.registry(), lab.library()).is_err());
}

/// A method from elsewhere that goes by the name of a variant of `basic`'s, or by its own.
struct Stranger(&'static str);

impl Part for Stranger {
    fn name(&self) -> &str {
        self.0
    }
}

impl ShadowMethod for Stranger {
    fn supports(&self, _: &Light) -> Support {
        Support::No("it shadows nothing".to_owned())
    }

    fn plan(&self, _: &Frame<'_>) -> Result<ShadowPlan, PlanError> {
        Ok(ShadowPlan::default())
    }
}

#[test]
fn a_method_without_a_variant_is_tried_as_it_is() {
    let lab = lab();
    let mut registry = lab.registry().clone();
    for name in ["ours", "basic 15"] {
        registry
            .methods
            .add(Stranger(name))
            .expect("a name of its own");
    }
    let limits = Limits::built_in().expect("a sound table");
    let variants = |limits: &Limits, methods: &[&str]| {
        let methods: Vec<_> = methods.iter().map(|name| (*name).to_owned()).collect();
        let variants = limits.variants_of(&methods, &registry, lab.library());
        variants.map_err(|error| error.to_string())
    };
    let names = |methods: &[&str]| {
        let variants = variants(&limits, methods).expect("sound variants");
        let names = variants.into_iter().map(|variant| variant.name);
        names.collect::<Vec<_>>()
    };
    assert_eq!(
        names(&["ours", "basic"]),
        [
            "ours",
            "basic",
            "basic 15",
            "basic midpoint",
            "basic esm",
            "basic esm half",
            "basic hpsm"
        ]
    );
    assert_eq!(
        variants(&limits, &["ours"]).expect("sound variants"),
        [Config {
            name: "ours".to_owned(),
            shadow: Shadow::new("ours"),
            path: umbrage_render::Path::default(),
        }]
    );
    // Else it would have the other's exceptions.
    let refused = variants(&limits, &["basic 15"]).expect_err("a variant's name");
    assert!(
        refused.contains("a variant of `basic` is called as the method `basic 15`")
            && refused.contains("limits.ron:"),
        "{refused}"
    );
    assert!(variants(&limits, &["none"]).is_err());

    let text = include_str!("../../limits.ron");
    for (from, to, message) in [
        (
            r#""fit": "tight""#,
            r#""fit": "tigth""#,
            "axis `fit` has no value `tigth`",
        ),
        (
            r#""fit": "tight""#,
            r#""fitting": "tight""#,
            "method `pssm` has no axis `fitting`",
        ),
        (
            r#"axes: {"fit": "tight"}"#,
            r#"settings: {"splits": 99}"#,
            "splits",
        ),
    ] {
        let text = text.replace(from, to);
        let line = 1 + text
            .lines()
            .position(|line| line.contains(to))
            .expect("the line");
        let limits = Limits::read(RonFile::new("limits.ron", text)).expect("a sound table");
        assert!(variants(&limits, &["basic"]).is_ok());
        let refused = variants(&limits, &["pssm"]).expect_err("no such choice");
        assert!(
            refused.contains(message) && refused.contains(&format!("limits.ron:{line}:")),
            "{refused}"
        );
    }
}

/// A case's own axes and settings are the case's; a variant that chooses otherwise is passed over, and says so.
#[test]
fn a_variant_is_tried_where_it_can_be_itself() {
    let mut lab = lab();
    let limits = Limits::built_in().expect("a sound table");
    let variant = |name: &str, method: &str, pcf: &str| Config {
        name: name.to_owned(),
        shadow: Shadow::new(method).with("pcf", pcf),
        path: umbrage_render::Path::default(),
    };
    let variants = [
        variant("three", "basic", "3"),
        variant("fifteen", "basic", "15"),
        variant("three splits", "pssm", "3"),
    ];
    let mut cases = cases::all();
    cases.retain(|case| ["steep-blocks-3", "open-mesh-mirrored"].contains(&case.name));
    let stressed = stress(&mut lab, &variants, &cases, &limits, None, &()).expect("measured");
    let tried: Vec<_> = (stressed.results.iter())
        .map(|result| (result.case, result.variant.as_str(), result.method.as_str()))
        .collect();
    assert_eq!(
        tried,
        [
            ("open-mesh-mirrored", "three", "basic"),
            ("open-mesh-mirrored", "fifteen", "basic"),
            ("steep-blocks-3", "three", "basic"),
            ("steep-blocks-3", "three splits", "pssm"),
        ]
    );
    // The variant's own choice is drawn.
    let rmse = |index: usize| stressed.results[index].figures.rmse;
    assert!(rmse(0) < rmse(1), "{} {}", rmse(0), rmse(1));
    let skipped: Vec<_> = (stressed.skipped.iter())
        .map(|(case, variant, _)| (*case, variant.as_str()))
        .collect();
    assert_eq!(
        skipped,
        [
            ("open-mesh-mirrored", "three splits"),
            ("steep-blocks-3", "fifteen")
        ]
    );
    assert_eq!(
        stressed.skipped[1].2,
        "the case has `pcf` at 3, the variant at 15"
    );
}

/// Decisions that no shader of a configuration can tell at once are not asked for; others are told as the picture has them.
#[test]
fn decisions_are_looked_for_where_filters_can_be_spared() {
    let mut lab = lab();
    let scene = example("bunny_sun.ron");
    let truth = Truth::trace(&scene, SIZE, &[], &|| ()).expect("traced");
    let subject = lab.subject(&scene, &truth).expect("drawn");
    let axis = lab.library().axes().get("filter").expect("an axis");
    let filters: Vec<_> = axis.values().map(str::to_owned).collect();
    // Bounds of so small a picture do not pay, and are built all the same.
    let filtered = &lab.registry().filters;
    let settings = |name: &str| filtered.get(name).expect("a filter").settings();
    let is_bounded = |name: &String| settings(name).iter().any(|s| s.name == "always_bounded");
    let bounded: Vec<_> = filters.iter().filter(|f| is_bounded(f)).cloned().collect();
    let config = |filter: &str| {
        let axes = [("filter", filter), ("pcf", "7"), ("block", "8")];
        let mut shadow = axes
            .into_iter()
            .fold(Shadow::new("basic"), |shadow, (a, v)| shadow.with(a, v));
        if bounded.iter().any(|name| name == filter) {
            shadow = shadow.with_setting("always_bounded", 1.0);
        }
        Config {
            shadow,
            ..Config::default()
        }
    };
    let mut able = 0;
    for filter in &filters {
        let own = config(filter);
        let options = own.options(SIZE);
        let counted = lab.fetches(&subject, &options).expect("drawn");
        let found = lab.decided(&subject, &own, mean(&counted)).expect("drawn");
        let options = RenderOptions {
            what: What::Decisions,
            ..options
        };
        let picture = lab.render(&scene, &options).expect("drawn").picture;
        let Picture::Decisions(drawn) = picture else {
            panic!("decisions were asked for");
        };
        let told = |found: &Decision| ![Decision::Unsampled, Decision::Filtered].contains(found);
        assert_eq!(found.is_some(), drawn.concat().iter().any(told), "{filter}");
        let Some((decided, picture)) = found else {
            continue;
        };
        able += 1;
        assert_eq!(picture.dimensions(), SIZE);
        let shares = decided.at_once() + decided.filtered;
        assert!((shares - 1.0).abs() < 1e-9, "{filter}: {decided:?}");
        // All but what stays open is told by a fetch, in place of sixteen.
        if filter == "hpsm" {
            let whole = lab.fetches(&subject, &config("pcf").options(SIZE));
            let asked = mean(&whole.expect("drawn")) / 16.0;
            let saved = asked * (16.0 * decided.at_once() - 1.0);
            let found = decided.fetches_saved.expect("the filter was chosen");
            assert!((found - saved).abs() < 1e-6, "{found}, not {saved}");
            assert!(decided.by_plane() > 0.5 && found > 5.0, "{decided:?}");
        }
    }
    assert!((1..filters.len()).contains(&able), "{able}");

    let named = |filter: &str| Config {
        name: filter.to_owned(),
        ..config(filter)
    };
    let options = CompareOptions {
        size: SIZE,
        most_pairs: 1,
        frames: 0,
        store: None,
        command: String::new(),
    };
    let scenes = [("bunny".to_owned(), scene)];
    let configs = [named("pcf"), named("min_max")];
    let compared = compare(
        &mut lab,
        &scenes,
        &configs,
        &options,
        Err(String::new()),
        &(),
    );
    let compared = compared.expect("measured");
    let [plain, bounded] = compared.report.rows.as_slice() else {
        panic!("two rows");
    };
    let found = bounded.decided.expect("it can tell");
    assert_eq!((plain.decided, found.by_plane()), (None, 0.0));
    assert!(found.by_depth() > 0.01, "{found:?}");
    let saved = plain.fetches_per_pixel - bounded.fetches_per_pixel;
    assert_eq!(found.fetches_saved, Some(saved));
    let decisions = |row: usize| {
        compared.pictures[row]
            .files()
            .any(|(name, _)| name == "decisions")
    };
    assert!(!decisions(0) && decisions(1));
}

#[test]
fn a_spread_has_its_middle() {
    let spread = |values: &[f64]| {
        let Spread { min, median, max } = Spread::of(values);
        [min, median, max]
    };
    assert_eq!(spread(&[3.0, 1.0, 2.0]), [1.0, 2.0, 3.0]);
    assert_eq!(spread(&[4.0, 1.0, 2.0, 3.0]), [1.0, 2.5, 4.0]);
    assert!(spread(&[]).iter().all(|value| value.is_nan()));
}

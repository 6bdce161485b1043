use std::fs;

use tempfile::TempDir;

use super::{json, path_in, refusal, stderr, stdout, umbrage, write};

const SCENE: &str = "examples/scenes/suzanne_spot.ron";

/// A floor and a ball under two lights.
const TWO_LIGHTS: &str = r#"(
    camera: (position: (0, 3, 4), target: (0, 0.5, 0)),
    lights: [
        (kind: directional(direction: (1, -1, 0))),
        (kind: point(position: (2, 3, 0), range: 20)),
    ],
    models: [
        (shape: plane(size: (9, 9))),
        (shape: sphere(radius: 0.5), translation: (0, 1, 0)),
    ],
)"#;

fn grey(path: &str) -> Vec<u8> {
    let picture = image::open(path).expect("a picture");
    assert!(matches!(picture, image::DynamicImage::ImageLuma8(_)));
    picture.into_luma8().into_raw()
}

#[test]
fn a_scene_becomes_its_true_shadow_term() {
    let folder = TempDir::new().expect("a folder");
    let out = path_in(&folder, "truth.png");
    let output = umbrage(&["truth", SCENE, "--size", "80x45", "--out", &out, "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let report = json(&output);
    assert_eq!(report["picture"], out.as_str());
    assert!(report["milliseconds"].as_f64().expect("a time") > 0.0);
    assert!(report["triangles"].as_u64() > Some(1000));
    let camera = &report["camera"];
    assert_eq!(
        (&camera["width"], &camera["height"]),
        (&80.into(), &45.into())
    );
    assert_eq!(camera["position"][2], 4.6);
    let forward = camera["forward"].as_array().expect("a vector");
    let length: f64 = forward
        .iter()
        .filter_map(|x| x.as_f64())
        .map(|x| x * x)
        .sum();
    assert!((length - 1.0).abs() < 1e-9 && camera["fov_y"].as_f64() < Some(1.0));
    assert_eq!(report["lights"][0]["kind"], "spot");
    assert_eq!(report["lights"][0]["range"], 20.0);
    let terms = grey(&out);
    assert_eq!(terms.len(), 80 * 45);
    assert!(terms.iter().all(|term| [0, 255].contains(term)));
    assert!(
        terms.contains(&0) && terms.contains(&255),
        "light and shadow"
    );

    let again = path_in(&folder, "again.png");
    let output = umbrage(&["truth", SCENE, "--size", "80x45", "--out", &again]);
    assert_eq!(stdout(&output), "");
    assert_eq!(
        fs::read(&out).expect("bytes"),
        fs::read(&again).expect("bytes")
    );
}

#[test]
fn the_picture_is_the_product_over_the_lights() {
    let folder = TempDir::new().expect("a folder");
    write(&folder, "two.ron", TWO_LIGHTS);
    let scene = path_in(&folder, "two.ron");
    let trace = |name: &str, options: &[&str]| {
        let out = path_in(&folder, name);
        let mut args = vec!["truth", &scene, "--size", "64x48", "--out", &out, "--json"];
        args.extend(options);
        let output = umbrage(&args);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        (grey(&out), json(&output))
    };
    let (first, _) = trace("first.png", &["--light", "0"]);
    let (second, report) = trace("second.png", &["--light=1"]);
    assert_eq!(report["lights"].as_array().map(Vec::len), Some(1));
    assert_eq!(report["lights"][0]["index"], 1);
    assert_eq!(report["lights"][0]["kind"], "point");
    assert!(first != second);
    let (both, report) = trace("both.png", &[]);
    assert_eq!(report["lights"].as_array().map(Vec::len), Some(2));
    let darker: Vec<_> = first.iter().zip(&second).map(|(a, b)| *a.min(b)).collect();
    assert_eq!(both, darker);
}

#[test]
fn lights_may_have_an_extent() {
    let folder = TempDir::new().expect("a folder");
    write(&folder, "two.ron", TWO_LIGHTS);
    let scene = path_in(&folder, "two.ron");
    let cache = path_in(&folder, "cache");
    let out = path_in(&folder, "a.png");
    let terms = |options: &[&str]| {
        let mut args = vec!["truth", &scene, "--size", "64x48", "--out", &out];
        args.extend(["--cache", &cache]);
        args.extend(options);
        let output = umbrage(&args);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        grey(&out)
    };
    let entries = || fs::read_dir(&cache).expect("listed").count();
    let between = |terms: &[u8]| terms.iter().filter(|term| !matches!(term, 0 | 255)).count();
    for (light, size) in [("0", "5"), ("1", "0.4")] {
        let sharp = terms(&["--light", light]);
        let soft = terms(&["--light", light, "--light-size", size]);
        assert_eq!(between(&sharp), 0, "light {light}");
        assert!(between(&soft) > 20, "light {light}: {}", between(&soft));
        let kept = entries();
        assert_eq!(terms(&["--light", light, "--light-size", size]), soft);
        assert_eq!(entries(), kept, "nothing was traced again");
        let finer = terms(&["--light", light, "--light-size", size, "--rays", "16"]);
        assert!(finer != soft && entries() == kept + 1);
    }
    let refused = |options: &[&str]| {
        let mut args = vec!["truth", &scene, "--out", &out];
        args.extend(options);
        refusal(&args)
    };
    assert!(refused(&["--light-size=-1"]).contains("size"));
    assert!(refused(&["--light-size", "NaN"]).contains("size"));
    assert!(refused(&["--light-size", "1", "--rays", "65"]).contains("1 to 64"));
    assert!(refused(&["--rays", "4"]).contains("--light-size"));
}

#[test]
fn what_cannot_be_traced() {
    let folder = TempDir::new().expect("a folder");
    let out = path_in(&folder, "a.png");
    let dark = TWO_LIGHTS.replace("lights: [", "lights: [],\n    ambient: (").replace(
        "        (kind: directional(direction: (1, -1, 0))),\n        (kind: point(position: (2, 3, 0), range: 20)),\n    ],",
        "1, 1, 1),",
    );
    write(&folder, "dark.ron", &dark);
    let said = refusal(&["truth", &path_in(&folder, "dark.ron"), "--out", &out]);
    assert!(
        said.contains("dark.ron") && said.contains("no lights"),
        "{said}"
    );
    let said = refusal(&["truth", SCENE, "--light", "1", "--out", &out]);
    assert!(said.contains("no light 1"), "{said}");
    let said = refusal(&["truth", SCENE, "--size", "999999x999999", "--out", &out]);
    assert!(said.contains("999999"), "{said}");
    assert!(refusal(&["truth", "gone.ron", "--out", &out]).contains("gone.ron"));
    assert!(
        !fs::exists(&out).expect("looked up"),
        "nothing is left behind"
    );
    for bad in ["gone/a.png", "a.jpeg"] {
        let bad = path_in(&folder, bad);
        assert!(refusal(&["truth", SCENE, "--out", &bad]).contains(&bad));
    }
    assert!(refusal(&["truth", SCENE]).contains("--out"));
    assert!(refusal(&["truth", SCENE, "--light=-1", "--out", &out]).contains("--light"));
}

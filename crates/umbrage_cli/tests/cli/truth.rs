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

/// The same pixels, by the same rule: lights without a `shadow` cast none, whatever method is asked for.
#[test]
fn a_picture_and_the_truth_count_the_same_lights() {
    let folder = TempDir::new().expect("a folder");
    let mixed = TWO_LIGHTS.replace(
        "(kind: directional(direction: (1, -1, 0)))",
        r#"(kind: directional(direction: (1, -1, 0)), shadow: (method: "basic"))"#,
    );
    write(&folder, "mixed.ron", &mixed);
    let scene = path_in(&folder, "mixed.ron");
    let draw = |command: &str, options: &[&str]| {
        let out = path_in(&folder, "picture.png");
        let mut args = vec![command, &scene, "--size", "64x48", "--out", &out, "--json"];
        if command == "render" {
            args.extend(["--what", "shadow-term"]);
        }
        args.extend(options);
        let output = umbrage(&args);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        (json(&output), grey(&out))
    };
    let dark = |grey: &[u8]| grey.iter().filter(|term| **term < 128).count();
    for options in [&[][..], &["--light", "0"], &["--light", "1"]] {
        let (report, truth) = draw("truth", options);
        let only_sun = report["lights"].as_array().expect("a list").len() == 1;
        assert_eq!(only_sun, options != ["--light", "1"], "{report}");
        for method in [&[][..], &["--method", "pssm"]] {
            let (report, drawn) = draw("render", &[options, method].concat());
            let differ = truth
                .iter()
                .zip(&drawn)
                .filter(|(a, b)| (**a < 128) != (**b < 128));
            assert!(differ.count() < 30, "{options:?} {method:?}");
            let lights = report["lights"].as_array().expect("a list").iter();
            let casts: Vec<_> = lights
                .map(|light| (&light["index"], &light["casts"]))
                .collect();
            let expected = [(0, true), (1, false)].map(|(at, casts)| (at.into(), casts.into()));
            for (index, casts) in casts {
                assert!(
                    expected.contains(&(index.clone(), casts.clone())),
                    "{report}"
                );
            }
        }
        assert_eq!(dark(&truth) > 0, options != ["--light", "1"]);
    }
    for command in ["truth", "render"] {
        let out = path_in(&folder, "none.png");
        let message = refusal(&[command, &scene, "--light", "2", "--out", &out]);
        assert!(
            message.contains("there is no light 2; the scene has 2"),
            "{message}"
        );
        let message = refusal(&[command, &scene, "--no-ground", "--out", &out]);
        assert!(
            message.contains("no ground and no sun but its own"),
            "{message}"
        );
    }
}

#[test]
fn an_orthographic_camera_is_told_by_its_height() {
    let folder = TempDir::new().expect("a folder");
    let text = TWO_LIGHTS.replace(
        "(0, 0.5, 0))",
        "(0, 0.5, 0), orthographic_height: 5, near: -3)",
    );
    write(&folder, "flat.ron", &text);
    let scene = path_in(&folder, "flat.ron");
    let out = path_in(&folder, "flat.png");
    let output = umbrage(&["truth", &scene, "--size", "40x30", "--out", &out, "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let camera = json(&output)["camera"].clone();
    assert!(camera["fov_y"].is_null(), "{camera}");
    assert_eq!(
        (&camera["orthographic_height"], &camera["near"]),
        (&5.0.into(), &(-3.0).into())
    );
}

use std::fs;

use tempfile::TempDir;

use super::{json, path_in, refusal, root, stderr, stdout, umbrage, write};

const SCENE: &str = "examples/scenes/bunny_sun.ron";

/// Two lights of one scene file, added up by one shader.
#[test]
fn a_shader_of_several_lights_has_their_keys() {
    let folder = TempDir::new().expect("a folder");
    let lamp = |x: i32| {
        format!(
            "(name: \"lamp {x}\", kind: point(position: ({x}, 2, 1), range: 9), intensity: 9, shadow: (method: \"basic\")),"
        )
    };
    let scene = format!(
        "(camera: (position: (0, 2, 4), target: (0, 0, 0)), lights: [{}{}], models: [(shape: plane(size: (9, 9)), name: \"ground\")])",
        lamp(-1),
        lamp(1)
    );
    write(&folder, "scene.ron", &scene);
    let (scene, out) = (path_in(&folder, "scene.ron"), path_in(&folder, "out.png"));
    let output = umbrage(&[
        "render",
        &scene,
        "--path",
        "forward_all",
        "--size",
        "64x48",
        "--out",
        &out,
    ]);
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(0), "{said}");
    let key = "light=point,method=basic,pass=illumination";
    assert!(said.contains(&format!("{key} + {key}: ground")), "{said}");
}

#[test]
fn a_scene_becomes_a_picture() {
    let folder = TempDir::new().expect("a folder");
    let (first, second) = (
        path_in(&folder, "first.png"),
        path_in(&folder, "second.png"),
    );
    let cache = path_in(&folder, "cache");
    let render = |out: &str| {
        let args = [
            "render", SCENE, "--size", "80x45", "--out", out, "--cache", &cache, "--json",
        ];
        let output = umbrage(&args);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        json(&output)
    };
    let report = render(&first);
    assert_eq!(report["picture"], first.as_str());
    assert!(!report["adapter"].as_str().expect("an adapter").is_empty());
    assert!(report["milliseconds"].as_f64().expect("a time") > 0.0);
    let count = |report: &serde_json::Value, name: &str| report["permutations"][name].as_u64();
    let composed = count(&report, "composed");
    assert!(composed > Some(0), "{report}");
    assert_eq!(count(&report, "cached"), Some(0));

    let report = render(&second);
    assert_eq!(count(&report, "composed"), Some(0));
    assert_eq!(count(&report, "cached"), composed);
    let picture = image::open(&first).expect("a picture");
    assert_eq!((picture.width(), picture.height()), (80, 45));
    assert_eq!(
        fs::read(&first).expect("bytes"),
        fs::read(&second).expect("bytes")
    );
}

#[test]
fn axes_and_settings_are_chosen_in_place_of_the_scenes() {
    let folder = TempDir::new().expect("a folder");
    let out = path_in(&folder, "out.png");
    let with = |more: &[&'static str]| {
        let args = ["render", SCENE, "--size", "80x45", "--out", &out];
        args.into_iter()
            .chain(more.iter().copied())
            .collect::<Vec<_>>()
    };
    let output = umbrage(&with(&[
        "--axis",
        "filter=hpsm",
        "--axis",
        "pcf=15",
        "--setting",
        "resolution=256",
        "--what",
        "decisions",
    ]));
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(
        stderr(&output).contains("filter=hpsm"),
        "{}",
        stderr(&output)
    );
    for (more, expected) in [
        (
            ["--axis", "filter=hpsn"],
            "axis `filter` has no value `hpsn`",
        ),
        (["--axis", "fitler=hpsm"], "did you mean `filter`?"),
        (
            ["--setting", "resolution=0"],
            "must be a whole number from 1",
        ),
        (["--setting", "resolution"], "a setting is NAME=NUMBER"),
    ] {
        let said = refusal(&with(&more));
        assert!(said.contains(expected), "{said}");
    }
}

#[test]
fn all_paths_draw_one_picture() {
    let folder = TempDir::new().expect("a folder");
    let pictures = ["forward", "mask", "mask_by_split"].map(|path| {
        let out = path_in(&folder, path);
        let out = format!("{out}.png");
        let output = umbrage(&[
            "render", SCENE, "--size", "80x45", "--path", path, "--out", &out,
        ]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let mut lines = stderr(&output).lines();
        let of_mask = |line: &str| line.contains("pass=mask") && line.contains("for the shadow of");
        let masked = lines.any(of_mask);
        assert_eq!(masked, path != "forward", "{}", stderr(&output));
        image::open(&out).expect("a picture").into_rgb8()
    });
    let [forward, masks @ ..] = pictures.each_ref().map(|picture| picture.as_raw());
    // A code of 8 bits, where a value lies between two.
    let alike = |(a, b): (&u8, &u8)| a.abs_diff(*b) <= 1;
    for mask in masks {
        assert!(forward.iter().zip(mask).all(alike));
    }
}

#[test]
fn a_person_reads_what_each_permutation_was_for() {
    let folder = TempDir::new().expect("a folder");
    let out = path_in(&folder, "a.png");
    let output = umbrage(&["render", SCENE, "--size", "80x45", "--out", &out]);
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(0), "{said}");
    let line = |pass: &str| said.lines().find(|line| line.contains(pass)).expect(pass);
    // A caster lies in no light: it is drawn so that others do not.
    assert!(
        line("pass=caster").ends_with("for the shadow of sun"),
        "{said}"
    );
    assert!(
        line("pass=illumination").ends_with("in the light of sun"),
        "{said}"
    );
    assert!(!line("pass=base").contains("sun"), "{said}");
}

#[test]
fn what_and_method_change_the_picture() {
    let folder = TempDir::new().expect("a folder");
    let render = |name: &str, options: &[&str]| {
        let out = path_in(&folder, name);
        let mut args = vec!["render", SCENE, "--size", "80x45", "--out", &out];
        args.extend(options);
        let output = umbrage(&args);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        assert_eq!(stdout(&output), "");
        image::open(&out)
            .expect("a picture")
            .into_luma8()
            .into_raw()
    };
    let shaded = render("shaded.png", &[]);
    assert_ne!(shaded, render("bare.png", &["--method", "none"]));
    let term = render("term.png", &["--what", "shadow-term"]);
    assert!(term.contains(&255) && term.contains(&0), "light and shadow");
    let unshadowed = render("lit.png", &["--what", "shadow-term", "--method", "none"]);
    assert!(unshadowed.iter().all(|term| *term == 255));
}

#[test]
fn a_bare_model_is_a_scene() {
    let folder = TempDir::new().expect("a folder");
    let out = path_in(&folder, "model.png");
    let output = umbrage(&[
        "render",
        "examples/scenes/suzanne.glb",
        "--size",
        "64x64",
        "--out",
        &out,
    ]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
}

#[test]
fn an_unknown_method() {
    let folder = TempDir::new().expect("a folder");
    let said = refusal(&[
        "render",
        SCENE,
        "--method",
        "basik",
        "--out",
        &path_in(&folder, "a.png"),
    ]);
    assert!(
        said.contains("basik") && said.contains("did you mean `basic`"),
        "{said}"
    );
    nothing_is_in(&folder);
}

#[test]
fn scenes_that_cannot_be_loaded() {
    let folder = TempDir::new().expect("a folder");
    let out = path_in(&folder, "a.png");
    for scene in ["gone.ron", "gone.glb"] {
        let said = refusal(&["render", scene, "--out", &out]);
        assert!(said.contains(scene), "{said}");
    }
    nothing_is_in(&folder);
    let model = fs::read(root().join("examples/scenes/suzanne.glb")).expect("a model");
    let truncated = path_in(&folder, "truncated.glb");
    fs::write(&truncated, &model[..model.len() / 2]).expect("a file");
    assert!(refusal(&["render", &truncated, "--out", &out]).contains("truncated.glb"));
    write(&folder, "half.ron", "(models: [");
    assert!(
        refusal(&["render", &path_in(&folder, "half.ron"), "--out", &out]).contains("half.ron:1")
    );
}

#[test]
fn places_that_cannot_be_written() {
    let folder = TempDir::new().expect("a folder");
    write(&folder, "file", "");
    for out in ["gone/a.png", "file/a.png", "a.jpeg", "a"] {
        let out = path_in(&folder, out);
        let said = refusal(&["render", SCENE, "--out", &out]);
        assert!(said.contains(&out), "{said}");
    }
    let cache = path_in(&folder, "file/cache");
    let out = path_in(&folder, "a.png");
    let said = refusal(&["render", SCENE, "--out", &out, "--cache", &cache]);
    assert!(said.contains(&cache), "{said}");
    let huge = refusal(&["render", SCENE, "--out", &out, "--size", "999999x1"]);
    assert!(huge.contains("999999"), "{huge}");
}

fn nothing_is_in(folder: &TempDir) {
    let left: Vec<_> = fs::read_dir(folder.path()).expect("a folder").collect();
    assert!(left.is_empty(), "{left:?}");
}

/// Features of a model that its picture does not show are told by name: to a person, and in the report.
#[test]
fn what_is_left_out_of_a_model_is_told() {
    let folder = TempDir::new().expect("a folder");
    let model = r#"{"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [
            {"attributes": {"POSITION": 0}, "material": 0}, {"attributes": {"POSITION": 0}, "mode": 0}]}],
        "materials": [{"emissiveFactor": [1, 0, 0], "extensions": {"KHR_materials_clearcoat": {}}}],
        "animations": [{}, {}],
        "buffers": [{"uri": "data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA", "byteLength": 36}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}]}"#;
    write(&folder, "model.gltf", model);
    let (model, out) = (path_in(&folder, "model.gltf"), path_in(&folder, "out.png"));
    for command in ["render", "truth"] {
        let output = umbrage(&[command, &model, "--size", "40x30", "--out", &out, "--json"]);
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(0), "{said}");
        for (line, expected) in said.lines().filter(|line| line.starts_with("left out")).zip([
            "left out: model.gltf: KHR_materials_clearcoat (1 place): surfaces have their colour, metalness and roughness alone",
            "left out: model.gltf: animations (2 places): the stored pose is drawn",
            "left out: model.gltf: emissiveFactor (1 place): nothing but lights shines",
            "left out: model.gltf: points (1 place): triangles alone are drawn",
        ]) {
            assert_eq!(line, expected);
        }
        assert_eq!(said.matches("left out: ").count(), 4, "{said}");
        let report = json(&output);
        let told = report["left_out"].as_array().expect("a list");
        assert_eq!(told.len(), 4);
        assert_eq!(told[1]["feature"], "animations");
        assert_eq!(told[1]["places"], 2);
        assert_eq!(told[1]["file"], "model.gltf");
    }
    let output = umbrage(&["render", SCENE, "--size", "40x30", "--out", &out, "--json"]);
    assert_eq!(json(&output)["left_out"], serde_json::json!([]));
    assert!(!stderr(&output).contains("left out"), "{}", stderr(&output));
}

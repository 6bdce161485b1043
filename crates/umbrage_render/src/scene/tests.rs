//! Models and scene files, good and bad, made by hand.

use std::{fs, path::PathBuf};

use glam::{DVec3, Vec3};
use tempfile::TempDir;
use umbrage_shadow::LightKind;

use super::{Scene, SceneError, Staging, Wrap};

/// Three floats a vertex: a triangle in the plane z = 0, facing +z; then four indices of each width.
fn triangle_bytes() -> Vec<u8> {
    let floats = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let mut bytes: Vec<u8> = floats.iter().flat_map(|x| x.to_le_bytes()).collect();
    bytes.extend([0_u8, 1, 2, 0]);
    bytes.extend([0_u16, 1, 2, 0].iter().flat_map(|i| i.to_le_bytes()));
    bytes.extend([0_u32, 1, 2, 0].iter().flat_map(|i| i.to_le_bytes()));
    bytes
}

/// A model of one triangle; each word of `changes` is replaced by its second half.
fn model(changes: &[(&str, &str)]) -> String {
    let mut json = r#"{
        "asset": {"version": "2.0"},
        "buffers": [{"uri": "part%20one.bin", "byteLength": 64}],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 36},
            {"buffer": 0, "byteOffset": 36, "byteLength": 28}
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3,
             "min": [0, 0, 0], "max": [1, 1, 0]},
            {"bufferView": 1, "componentType": 5121, "type": "SCALAR", "count": 3}
        ],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "nodes": [{"mesh": 0, "name": "tri"}],
        "scenes": [{"nodes": [0]}], "scene": 0
    }"#
    .to_owned();
    for (from, to) in changes {
        assert!(json.contains(from), "{from}");
        json = json.replace(from, to);
    }
    json
}

fn load_model(changes: &[(&str, &str)], bytes: &[u8]) -> Result<Scene, SceneError> {
    let dir = TempDir::new().expect("a folder");
    fs::write(dir.path().join("part one.bin"), bytes).expect("written");
    let path = dir.path().join("model.gltf");
    fs::write(&path, model(changes)).expect("written");
    Scene::load(path)
}

/// The error's text, without the folder.
fn refuse(result: Result<Scene, SceneError>) -> String {
    let message = result.expect_err("refused").to_string();
    assert!(!message.contains('\n'), "one paragraph: {message}");
    message
}

fn assert_refused(changes: &[(&str, &str)], expected: &str) {
    let message = refuse(load_model(changes, &triangle_bytes()));
    assert!(message.contains(expected), "{message}\nlacks: {expected}");
}

#[test]
fn models_load_with_indices_of_every_width_or_none() {
    let widths = [
        vec![],
        vec![
            ("5121", "5123"),
            (
                r#""bufferView": 1,"#,
                r#""bufferView": 1, "byteOffset": 4,"#,
            ),
        ],
        vec![
            ("5121", "5125"),
            (
                r#""bufferView": 1,"#,
                r#""bufferView": 1, "byteOffset": 12,"#,
            ),
        ],
        vec![(r#", "indices": 1"#, "")],
        vec![(r#""indices": 1"#, r#""indices": 1, "mode": 5"#)],
        vec![(r#""indices": 1"#, r#""indices": 1, "mode": 6"#)],
    ];
    for changes in widths {
        let scene = load_model(&changes, &triangle_bytes()).expect("loads");
        let object = &scene.objects[0];
        assert_eq!(object.name, "tri");
        assert_eq!(object.mesh.indices, [0, 1, 2]);
        // It has no normals: they are computed, flat.
        assert_eq!(object.mesh.normals, [Vec3::Z; 3]);
        assert_eq!(object.bounds.max, DVec3::new(1.0, 1.0, 0.0));
        // A bare model gets a ground, a sun and a camera.
        assert_eq!(scene.objects[1].name, "ground");
        assert!(matches!(
            scene.lights[0].light.kind,
            LightKind::Directional { .. }
        ));
    }
}

/// So that a floor of the model's own, or the whole of a flat model, never shares the ground's depth.
#[test]
fn a_bare_model_lies_off_its_ground_by_less_than_a_pixel() {
    // As it is, and lying in its plane.
    let lying = r#""name": "tri", "rotation": [-0.7071067811865476, 0, 0, 0.7071067811865476]"#;
    for nodes in [r#""name": "tri""#, lying] {
        let scene = load_model(&[(r#""name": "tri""#, nodes)], &triangle_bytes()).expect("loads");
        let (model, ground) = (scene.objects[0].bounds, scene.objects[1].bounds);
        let radius = 0.5 * model.min.distance(model.max);
        let gap = model.min.y - ground.max.y;
        // Positions and depths of f32 at the ground's far end, twelve radii and the camera's four away.
        let rounding = 16.0 * 16.0 * radius * f64::from(f32::EPSILON);
        let view = scene.view(1280, 720);
        let distance = (model.center() - view.position).length();
        let pixel = view.projection.size_at(distance).y / 720.0;
        assert!(
            gap > rounding && gap < 0.5 * pixel,
            "{gap} {rounding} {pixel}"
        );
    }
}

#[test]
fn a_bare_model_may_go_without_ground_and_sun() {
    let dir = TempDir::new().expect("a folder");
    fs::write(dir.path().join("part one.bin"), triangle_bytes()).expect("written");
    let path = dir.path().join("model.gltf");
    fs::write(&path, model(&[])).expect("written");
    for (ground, sun) in [(true, true), (true, false), (false, true), (false, false)] {
        let scene = Scene::load_with(&path, Staging { ground, sun }).expect("loads");
        assert_eq!(scene.objects.len(), 1 + usize::from(ground));
        assert_eq!(scene.lights.len(), usize::from(sun));
    }
    let file = dir.path().join("scene.ron");
    fs::write(&file, "()").expect("written");
    let bare = Staging {
        ground: false,
        sun: true,
    };
    let message = refuse(Scene::load_with(&file, bare));
    assert!(
        message.contains("no ground and no sun but its own"),
        "{message}"
    );
}

#[test]
fn nodes_pass_their_transforms_down_to_instances() {
    let nodes = r#"[
        {"children": [1, 2], "translation": [10, 0, 0], "scale": [2, 2, 2]},
        {"mesh": 0, "translation": [0, 1, 0]},
        {"mesh": 0, "matrix": [-1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]}]"#;
    let scene = load_model(
        &[(r#"[{"mesh": 0, "name": "tri"}]"#, nodes)],
        &triangle_bytes(),
    );
    let scene = scene.expect("loads");
    assert_eq!(scene.objects.len(), 3);
    assert!(std::sync::Arc::ptr_eq(
        &scene.objects[0].mesh,
        &scene.objects[1].mesh
    ));
    assert_eq!(scene.objects[0].bounds.min, DVec3::new(10.0, 2.0, 0.0));
    assert_eq!(scene.objects[1].bounds.min, DVec3::new(8.0, 0.0, 0.0));
}

#[test]
fn materials_keep_their_textures_and_cut_offs() {
    // One red texel, half transparent.
    let texel = image::RgbaImage::from_pixel(1, 1, image::Rgba([255, 0, 0, 128]));
    let mut png = std::io::Cursor::new(Vec::new());
    texel
        .write_to(&mut png, image::ImageFormat::Png)
        .expect("encoded");
    let mut bytes = triangle_bytes();
    let length = png.get_ref().len();
    bytes.extend(png.into_inner());
    let view = format!(
        r#""bufferViews": [
            {{"buffer": 0, "byteOffset": 64, "byteLength": {length}}},"#
    );
    let total = format!("\"byteLength\": {}", bytes.len());
    let changes = [
        ("\"byteLength\": 64", total.as_str()),
        ("\"bufferViews\": [", view.as_str()),
        ("\"bufferView\": 1,", "\"bufferView\": 2,"),
        ("\"bufferView\": 0,", "\"bufferView\": 1,"),
        ("\"indices\": 1", "\"indices\": 1, \"material\": 0"),
        (
            "\"scene\": 0",
            r#""scene": 0, "images": [{"bufferView": 0, "mimeType": "image/png"}],
            "samplers": [{"wrapS": 33071, "wrapT": 33648, "magFilter": 9728}],
            "textures": [{"source": 0, "sampler": 0}],
            "materials": [{"alphaMode": "MASK", "alphaCutoff": 0.25, "pbrMetallicRoughness":
                {"baseColorTexture": {"index": 0}, "roughnessFactor": 0.5, "metallicFactor": 0}}]"#,
        ),
    ];
    let scene = load_model(&changes, &bytes).expect("loads");
    let material = &scene.objects[0].material;
    assert_eq!(
        (material.alpha_cutoff, material.roughness),
        (Some(0.25), 0.5)
    );
    let texture = material.base_color_texture.as_ref().expect("a texture");
    assert_eq!(texture.image.levels[0].rgba, [[255, 0, 0, 128]]);
    assert_eq!(
        (texture.wrap, texture.smooth),
        ([Wrap::Clamp, Wrap::Mirror], false)
    );

    let broken = refuse(load_model(&changes, &bytes[..bytes.len() - 20]));
    assert!(broken.contains("buffers[0]"), "{broken}");
    bytes[64..72].fill(0);
    let broken = refuse(load_model(&changes, &bytes));
    assert!(
        broken.contains("images[0]: the picture cannot be decoded"),
        "{broken}"
    );
}

#[test]
fn models_that_lie_about_their_data_are_refused() {
    assert_refused(
        &[("\"byteLength\": 64", "\"byteLength\": 65")],
        "buffers[0]: it has 64 of 65",
    );
    assert_refused(
        &[("\"byteLength\": 36", "\"byteLength\": 999")],
        "bufferViews[0]: 999 bytes",
    );
    assert_refused(
        &[("\"byteOffset\": 36", "\"byteOffset\": 18446744073709551615")],
        "bufferViews[1]: 28 bytes from byte 18446744073709551615",
    );
    assert_refused(
        &[(
            "\"type\": \"VEC3\", \"count\": 3",
            "\"type\": \"VEC3\", \"count\": 4",
        )],
        "accessors[0]: 4 elements of 12 bytes",
    );
    assert_refused(
        &[(
            "\"SCALAR\", \"count\": 3",
            "\"SCALAR\", \"count\": 18446744073709551615",
        )],
        "accessors[1]: 18446744073709551615 elements",
    );
    assert_refused(
        &[(
            "\"bufferView\": 0,",
            "\"bufferView\": 0, \"byteOffset\": 40,",
        )],
        "accessors[0]: 3 elements of 12 bytes from byte 40",
    );
    assert_refused(
        &[(
            "\"byteLength\": 36}",
            "\"byteLength\": 36, \"byteStride\": 4}",
        )],
        "overlap at a stride of 4",
    );
    assert_refused(
        &[("\"VEC3\"", "\"VEC2\"")],
        "accessors[0]: it is a VEC2, but meshes[0].primitives[0] needs a VEC3",
    );
    assert_refused(&[("5126", "5125")], "components of type 5125 are not known");
    assert_refused(
        &[("\"POSITION\": 0", "\"POSITION\": 7")],
        "meshes[0].primitives[0]: it names accessors[7], but there are 2",
    );
    assert_refused(
        &[("\"mesh\": 0", "\"mesh\": 3")],
        "nodes[0]: it names meshes[3], but there are 1",
    );
    assert_refused(
        &[("\"indices\": 1", "\"indices\": 0")],
        "accessors[0]: it is a VEC3",
    );
    assert_refused(
        &[("\"POSITION\": 0", "\"POSITION\": 0, \"NORMAL\": 1")],
        "accessors[1]",
    );
    assert_refused(&[("\"nodes\": [0]", "\"nodes\": []")], "has no nodes");
    assert_refused(
        &[("\"mode\"", "\"mode\"")].map(|_| ("\"mesh\": 0, ", "")),
        "nothing to see",
    );
    assert_refused(
        &[(
            "\"version\": \"2.0\"}",
            "\"version\": \"2.0\"}, \"extensionsRequired\": [\"KHR_x\"]",
        )],
        "cannot be read without KHR_x",
    );
    assert_refused(&[("part%20one.bin", "gone.bin")], "gone.bin");
    assert_refused(&[("part%20one.bin", "%ff.bin")], "percent-encoded");
    assert_refused(
        &[("part%20one.bin", "http://host/x.bin")],
        "not a relative path",
    );
    assert_refused(&[("part%20one.bin", "data:;base64,!")], "bad data URI");
}

#[test]
fn indices_beyond_the_vertices_and_numbers_that_are_none_are_refused() {
    let mut bytes = triangle_bytes();
    bytes[37] = 3;
    let message = refuse(load_model(&[], &bytes));
    assert!(
        message.contains("accessors[1]: element 1 names vertex 3"),
        "{message}"
    );

    let mut bytes = triangle_bytes();
    bytes[12..16].copy_from_slice(&f32::NAN.to_le_bytes());
    let message = refuse(load_model(&[], &bytes));
    assert!(
        message.contains("accessors[0]: element 1 is [NaN, 0.0, 0.0]"),
        "{message}"
    );
}

#[test]
fn nodes_that_form_no_tree_or_stand_nowhere_are_refused() {
    let nodes = |text: &str| {
        refuse(load_model(
            &[(r#"[{"mesh": 0, "name": "tri"}]"#, text)],
            &triangle_bytes(),
        ))
    };
    assert!(nodes(r#"[{"mesh": 0, "children": [0]}]"#).contains("nodes must form a tree"));
    assert!(nodes(r#"[{"children": [1]}, {"mesh": 0, "children": [0]}]"#).contains("nodes[0]"));
    let twice =
        r#"[{"scale": [1e300, 1, 1], "children": [1]}, {"mesh": 0, "scale": [1e300, 1, 1]}]"#;
    assert!(nodes(twice).contains("nodes[1]: its transform is not finite"));
    assert!(nodes(r#"[{"mesh": 0, "scale": [1e39, 1, 1]}]"#).contains("farther than"));
    assert!(nodes(r#"[{"mesh": 0, "translation": [1e30, 1, 1]}]"#).contains("farther than"));
}

#[test]
fn damaged_files_are_refused() {
    let dir = TempDir::new().expect("a folder");
    let load = |name: &str, bytes: &[u8]| {
        let path = dir.path().join(name);
        fs::write(&path, bytes).expect("written");
        refuse(Scene::load(path))
    };
    let whole = fs::read(scenes().join("bunny.glb")).expect("a model");
    for length in [4, 11, 12, 19, 20, 400, whole.len() - 1] {
        let message = load("cut.glb", &whole[..length]);
        assert!(message.contains("cut.glb"), "{message}");
    }
    let mut lying = whole.clone();
    lying[8..12].copy_from_slice(&[3, 0, 0, 0]);
    assert!(load("lying.glb", &lying).contains("3 bytes long"));
    assert!(load("empty.gltf", b"").contains("no glTF 2.0"));
    assert!(load("scene.obj", b"").contains("no scene"));
    assert!(refuse(Scene::load(dir.path().join("gone.glb"))).contains("cannot read"));
}

fn scenes() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../examples/scenes")
}

const GOOD: &str = r#"(
    camera: (position: (0, 1, 5), target: (0, 1, 0)),
    lights: [
        (kind: spot(position: (0, 4, 0), target: (0, 0, 0), outer_degrees: 30, range: 10),
         color: (1, 0.5, 0.25), intensity: 2,
         shadow: (method: "basic", axes: {"pcf": "5"}, settings: {"resolution": 512})),
    ],
    models: [
        (shape: plane(size: (4, 4), tiles: (2, 2)), surface: "ggx", casts: false),
        (shape: sphere(radius: 0.5), translation: (1e6, 0, 0), scale: (-1, 1, 1)),
    ],
)"#;

fn load_scene(changes: &[(&str, &str)]) -> Result<Scene, SceneError> {
    let dir = TempDir::new().expect("a folder");
    let mut text = GOOD.to_owned();
    for (from, to) in changes {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, to);
    }
    let path = dir.path().join("test.ron");
    fs::write(&path, text).expect("written");
    Scene::load(path)
}

#[test]
fn scene_files_load() {
    let scene = load_scene(&[]).expect("loads");
    assert!((scene.camera.rotation * DVec3::NEG_Z).abs_diff_eq(DVec3::NEG_Z, 1e-12));
    assert_eq!(scene.medium, None);
    let dusty = load_scene(&[("lights: [", "medium: (scattering: 0.5), lights: [")]);
    let medium = dusty.expect("loads").medium.expect("it has one");
    assert_eq!(
        [medium.scattering, medium.absorption, medium.anisotropy],
        [0.5, 0.0, 0.0]
    );
    assert!(!scene.objects[0].material.casts);
    assert_eq!(scene.objects[0].material.surface, "ggx");
    assert_eq!(scene.objects[1].bounds.max.x, 1_000_000.5);
    let light = &scene.lights[0];
    assert_eq!(light.light.color, Vec3::new(2.0, 1.0, 0.5));
    let LightKind::Spot { direction, .. } = light.light.kind else {
        unreachable!()
    };
    assert_eq!(direction, DVec3::NEG_Y);
    let shadow = light.shadow.as_ref().expect("a shadow");
    assert_eq!(
        (shadow.axes["pcf"].as_str(), shadow.settings["resolution"]),
        ("5", 512.0)
    );
}

#[test]
fn bad_scene_files_are_refused() {
    let cases = [
        (
            "target: (0, 1, 0)",
            "target: (0, 1, 0), orthographic_height: 0",
            "camera.orthographic_height: it is 0",
        ),
        (
            "target: (0, 1, 0)",
            "target: (0, 1, 0), orthographic_height: 3, fov_degrees: 30",
            "camera: it has both an angle, `fov_degrees`, and an `orthographic_height`",
        ),
        (
            "target: (0, 1, 0)",
            "target: (0, 1, 0), orthographic_height: 3, near: -4, far: -5",
            "camera.far: it is -5, but must lie beyond near, -4",
        ),
        (
            "target: (0, 1, 0)",
            "target: (0, 1, 0), near: -1",
            "camera.near: it is -1",
        ),
        ("target: (0, 1, 0)", "aim: (0, 1, 0)", "test.ron:2:"),
        ("casts: false", "cast: false", "test.ron:9:"),
        ("(shape: plane", "(\"", "test.ron:9:10"),
        (
            "    camera: (position: (0, 1, 5), target: (0, 1, 0)),\n",
            "",
            "camera",
        ),
        ("(0, 1, 5)", "(NaN, 1, 5)", "camera.position: it is NaN"),
        (
            "(0, 1, 5)",
            "(0, 1, 0)",
            "camera.target: it is where the camera stands",
        ),
        (
            "target: (0, 1, 0)",
            "fov_degrees: 30",
            "either a target or a rotation",
        ),
        (
            "target: (0, 1, 0)",
            "rotation: quaternion(0, 0, 0, 0)",
            "camera.rotation: it is no",
        ),
        (
            "target: (0, 1, 0)",
            "target: (0, 1, 0), near: 5, far: 4",
            "camera.far: it is 4",
        ),
        ("range: 10", "range: -1", "lights[0].kind.range: it is -1"),
        (
            "outer_degrees: 30",
            "outer_degrees: 95",
            "lights[0].kind.outer_degrees",
        ),
        (
            "outer_degrees: 30",
            "outer_degrees: 30, inner_degrees: 30",
            "lights[0].kind.inner_degrees",
        ),
        (
            "target: (0, 0, 0)",
            "target: (0, 4, 0)",
            "lights[0].kind.direction: it has no length",
        ),
        (
            "intensity: 2",
            "intensity: inf",
            "lights[0].intensity: it is inf",
        ),
        (
            "intensity: 2",
            "intensity: 2, cookie: \"gone.png\"",
            "gone.png",
        ),
        (
            "lights: [",
            "medium: (scattering: -0.1), lights: [",
            "medium.scattering: it is -0.1, but must lie from 0 to 1e6\n",
        ),
        (
            "lights: [",
            "medium: (absorption: NaN), lights: [",
            "medium.absorption: it is NaN",
        ),
        (
            "lights: [",
            "medium: (anisotropy: 1), lights: [",
            "medium.anisotropy: it is 1",
        ),
        (
            "lights: [",
            "medium: (density: 1),\nlights: [",
            "unexpected field named `density`",
        ),
        ("radius: 0.5", "radius: 0", "models[1].shape.radius"),
        (
            "radius: 0.5",
            "radius: 0.5, segments: 2",
            "models[1].shape.segments",
        ),
        ("(-1, 1, 1)", "(inf, 1, 1)", "models[1].scale: it is inf"),
        (
            "(-1, 1, 1)",
            "(1, 1, 1), material: (metallic: 2)",
            "`metallic` is 2",
        ),
        (
            "shape: sphere(radius: 0.5),",
            "",
            "models[1]: a model is either a file or a shape",
        ),
        (
            "shape: sphere(radius: 0.5),",
            "file: \"gone.glb\",",
            "gone.glb",
        ),
    ];
    for (from, to, expected) in cases {
        let message = load_scene(&[(from, to)]).expect_err("refused").to_string();
        assert!(message.contains(expected), "{message}\nlacks: {expected}");
    }
}

#[test]
fn faults_of_scene_files_have_their_place_and_a_remedy() {
    let told = |from: &str, to: &str| {
        let message = load_scene(&[(from, to)]).expect_err("refused").to_string();
        let line = 1 + GOOD[..GOOD.find(from).expect("in it")]
            .matches('\n')
            .count();
        assert!(message.contains(&format!("test.ron:{line}:")), "{message}");
        message
    };
    let range = told("range: 10", "range: -1");
    assert!(
        range.starts_with("lights[0].kind.range: it is -1, but must lie from 1e-6 to 1e12\n"),
        "{range}"
    );
    // The value itself is marked.
    let marked = range.split_once("range: -1").expect("an excerpt").1;
    assert!(
        marked.contains(" ^^\n  = change it in the scene file\n"),
        "{range}"
    );
    let misspelt = told("casts: false", "cast: false");
    assert!(
        misspelt.starts_with("unexpected field named `cast`"),
        "{misspelt}"
    );
    assert!(
        misspelt.ends_with("  = did you mean `casts`?\n"),
        "{misspelt}"
    );
    // A missing entry has its place where it would be.
    let missing = told("target: (0, 1, 0)", "fov_degrees: 30");
    assert!(
        missing.contains("either a target or a rotation"),
        "{missing}"
    );
}

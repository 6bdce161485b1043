//! Shapes of a glTF model cast the shadows they should: in the picture, in the truth, and by hand.

mod common;

use std::fs;

use glam::DVec3;
use serde_json::{Value, json};
use tempfile::TempDir;
use umbrage_measure::truth::{Source, Tracer};
use umbrage_render::{Picture, RenderOptions, Scene, What};

use common::renderer;

const SIZE: (u32, u32) = (640, 480);

/// A buffer in the making, with its views and accessors.
#[derive(Default)]
struct Data {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Data {
    fn view(&mut self, bytes: &[u8]) -> usize {
        let start = self.bytes.len();
        self.views
            .push(json!({"buffer": 0, "byteOffset": start, "byteLength": bytes.len()}));
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.len() - 1
    }

    fn add(&mut self, kind: &str, component: u32, count: usize, bytes: &[u8]) -> usize {
        let view = self.view(bytes);
        self.accessors
            .push(json!({"bufferView": view, "componentType": component,
            "normalized": component < 5123, "count": count, "type": kind}));
        self.accessors.len() - 1
    }

    fn floats(&mut self, kind: &str, count: usize, floats: &[f32]) -> usize {
        let bytes: Vec<u8> = floats.iter().flat_map(|x| x.to_le_bytes()).collect();
        self.add(kind, 5126, count, &bytes)
    }
}

/// Level squares with a side of 2, a metre above the ground: three instances of one of 8-bit positions along x, and
/// before them one that is cut by a moved texture, one by the opacities of its vertices, and one that hangs on a
/// joint.
fn model(folder: &TempDir) {
    let mut data = Data::default();
    let square = [-127, 0, -127, 127, 0, -127, 127, 0, 127, -127, 0, 127].map(|x: i8| x as u8);
    let square = data.add("VEC3", 5120, 4, &square);
    let indices = data.view(&[0, 2, 1, 0, 3, 2]);
    data.accessors
        .push(json!({"bufferView": indices, "componentType": 5121, "count": 6, "type": "SCALAR"}));
    let indices = data.accessors.len() - 1;
    let uvs = data.floats("VEC2", 4, &[0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0]);
    let clear = [9, 9, 9, 0];
    let solid = [9, 9, 9, 255];
    let colors = data.add("VEC4", 5121, 4, &[clear, solid, solid, clear].concat());
    let joints = data.view(&[0; 16]);
    data.accessors
        .push(json!({"bufferView": joints, "componentType": 5121, "count": 4, "type": "VEC4"}));
    let joints = data.accessors.len() - 1;
    let weights = data.floats("VEC4", 4, &[1.0, 0.0, 0.0, 0.0].repeat(4));
    let places = data.floats("VEC3", 3, &[-3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 3.0, 0.0, 0.0]);
    // Solid on the left, clear on the right; moved by half of itself, the other way round.
    let picture = image::RgbaImage::from_fn(2, 1, |x, _| {
        image::Rgba([9, 9, 9, if x == 0 { 255 } else { 0 }])
    });
    picture
        .save(folder.path().join("halves.png"))
        .expect("written");
    let primitive = |more: Value, material: usize| {
        let mut attributes = json!({"POSITION": square});
        for (name, value) in more.as_object().expect("members") {
            attributes[name] = value.clone();
        }
        json!({"primitives": [{"attributes": attributes, "indices": indices, "material": material}]})
    };
    let file = json!({
        "asset": {"version": "2.0"},
        "extensionsRequired": ["EXT_mesh_gpu_instancing", "KHR_mesh_quantization", "KHR_texture_transform"],
        "buffers": [{"uri": "model.bin", "byteLength": data.bytes.len()}],
        "bufferViews": data.views, "accessors": data.accessors,
        "images": [{"uri": "halves.png"}],
        "samplers": [{"magFilter": 9728}],
        "textures": [{"source": 0, "sampler": 0}],
        "materials": [
            {},
            {"alphaMode": "MASK", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0,
                "extensions": {"KHR_texture_transform": {"offset": [0.5, 0]}}}}},
            {"alphaMode": "MASK"},
        ],
        "meshes": [
            primitive(json!({}), 0),
            primitive(json!({"TEXCOORD_0": uvs}), 1),
            primitive(json!({"COLOR_0": colors}), 2),
            primitive(json!({"JOINTS_0": joints, "WEIGHTS_0": weights}), 0),
        ],
        "skins": [{"joints": [4]}],
        "nodes": [
            {"mesh": 0, "translation": [0, 1, 0],
             "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": places}}}},
            {"mesh": 1, "translation": [-3, 1, 3]},
            {"mesh": 2, "translation": [0, 1, 3]},
            {"mesh": 3, "skin": 0, "translation": [40, 40, 40]},
            {"translation": [3, 1, 3]},
        ],
    });
    fs::write(folder.path().join("model.bin"), &data.bytes).expect("written");
    fs::write(folder.path().join("model.gltf"), file.to_string()).expect("written");
}

#[test]
fn instances_skins_and_holes_cast_their_shadows() {
    let folder = TempDir::new().expect("a folder");
    model(&folder);
    let text = r#"(
        camera: (position: (0, 2.5, 12), target: (0, 0, 1.5)),
        lights: [(kind: directional(direction: (0, -1, 0)),
                  shadow: (method: "basic", axes: {"pcf": "1"}, settings: {"resolution": 4096}))],
        models: [(shape: plane(size: (12, 12))), (file: "model.gltf")],
    )"#;
    let path = folder.path().join("scene.ron");
    fs::write(&path, text).expect("written");
    let scene = Scene::load(&path).expect("a sound scene");
    assert!(scene.left_out.is_empty(), "{:?}", scene.left_out);
    let options = RenderOptions {
        width: SIZE.0,
        height: SIZE.1,
        what: What::ShadowTerm,
        ..RenderOptions::default()
    };
    let rendered = renderer().render(&scene, &options).expect("renders");
    let Picture::ShadowTerm(terms) = &rendered.picture else {
        unreachable!("a shadow term was asked for")
    };
    let tracer = Tracer::new(&scene).expect("a sound scene");
    let sight = tracer.look(SIZE.0, SIZE.1, &|| ()).expect("a size");
    let truth = tracer
        .shadow(&sight, 0, Source::Sharp, &|| ())
        .expect("a light");

    let (mut wrong, mut by_hand) = (0, [0; 2]);
    for (pixel, (seen, truth)) in sight.seen().iter().zip(&truth).enumerate() {
        let (Some(seen), Some(truth)) = (seen, truth) else {
            continue;
        };
        wrong += usize::from((terms[0][pixel] - truth).abs() > 0.5);
        let point = scene.camera.position + seen.position;
        // The ground, but for a strip along each shadow's edge.
        if let (0, Some(is_dark)) = (seen.object, is_dark(point)) {
            let expected = if is_dark { 0.0 } else { 1.0 };
            assert_eq!((*truth, terms[0][pixel]), (expected, expected), "{point}");
            by_hand[usize::from(is_dark)] += 1;
        }
    }
    assert!(by_hand[0] > 10_000 && by_hand[1] > 3_000, "{by_hand:?}");
    // Pixels that an edge goes through.
    assert!(wrong < 2_000, "{wrong}");
}

/// Whether a point on the ground lies under a square; none near the edge of one.
fn is_dark(point: DVec3) -> Option<bool> {
    const STRIP: f64 = 0.02;
    let within = |x: [f64; 2], z: f64, by: f64| {
        point.x > x[0] - by && point.x < x[1] + by && (point.z - z).abs() < 1.0 + by
    };
    // Of the textured and of the coloured square the right halves are there.
    let squares = [
        ([-4.0, -2.0], 0.0),
        ([-1.0, 1.0], 0.0),
        ([2.0, 4.0], 0.0),
        ([-3.0, -2.0], 3.0),
        ([0.0, 1.0], 3.0),
        ([2.0, 4.0], 3.0),
    ];
    let under = |by: f64| squares.iter().any(|(x, z)| within(*x, *z, by));
    (under(STRIP) == under(-STRIP)).then(|| under(0.0))
}

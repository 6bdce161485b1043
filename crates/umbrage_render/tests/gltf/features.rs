//! The table of features agrees with the reader on each of them.

use std::collections::BTreeMap;

use serde_json::json;
use umbrage_render::Scene;

use crate::maker::{F32, I8, Maker, U8, corners, left_out, triangle};

const TABLE: &str = include_str!("../../src/scene/model/features.md");

/// Outcome that the table gives for a feature.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Outcome {
    Done,
    Told,
    Refused,
}

/// Puts a feature into a file.
type Add = fn(&mut Maker);

/// Whether a feature is seen in the scene.
type Seen = fn(&Scene) -> bool;

fn anything(_: &Scene) -> bool {
    true
}

/// The name of each row, a file with its feature, and what tells it.
fn rows() -> BTreeMap<&'static str, (Add, Seen)> {
    let mut rows: BTreeMap<&'static str, (Add, Seen)> = BTreeMap::new();
    let mut row = |name, add: Add, seen: Seen| {
        assert!(rows.insert(name, (add, seen)).is_none(), "{name}");
    };
    row(
        "`.gltf` and `.glb`, buffers and pictures within or beside",
        |_| {},
        anything,
    );
    row("`scene`", |maker| maker.json["scene"] = json!(0), anything);
    row(
        "nodes with `matrix` or `translation`, `rotation`, `scale`",
        |maker| {
            maker.json["nodes"][0]["scale"] = json!([1, 2, 1]);
        },
        |scene| corners(scene, 0)[2].y == 2.0,
    );
    row(
        "triangles, strips, fans",
        |maker| {
            maker.json["meshes"][0]["primitives"][0]["mode"] = json!(5);
        },
        |scene| corners(scene, 0).len() == 3,
    );
    row(
        "accessors: sparse, without a view, of any stride",
        |maker| {
            let (indices, values) = (
                maker.view(&[2]),
                maker.view(&[0.0_f32, 7.0, 0.0].map(f32::to_le_bytes).concat()),
            );
            maker.json["accessors"][0]["sparse"] = json!({"count": 1,
            "indices": {"bufferView": indices, "componentType": U8}, "values": {"bufferView": values}});
        },
        |scene| corners(scene, 0)[2].y == 7.0,
    );
    row(
        "`KHR_mesh_quantization`",
        |maker| {
            let positions = maker.accessor("VEC3", I8, 3, &[0, 0, 0, 9, 0, 0, 0, 9, 0]);
            maker.attribute("POSITION", positions);
            maker.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
        },
        |scene| corners(scene, 0)[2].y == 9.0,
    );
    row(
        "`EXT_mesh_gpu_instancing`",
        |maker| {
            let places = maker.floats(&[[0.0_f32, 0.0, 0.0], [5.0, 0.0, 0.0]]);
            maker.json["nodes"][0]["extensions"] =
                json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": places}}});
        },
        |scene| corners(scene, 1)[0].x == 5.0,
    );
    row(
        "`skins`",
        |maker| {
            add_skin(maker);
            maker.push("nodes", json!({"translation": [0, 8, 0]}));
        },
        |scene| corners(scene, 0)[0].y == 8.0,
    );
    row(
        "morph targets (`weights`)",
        |maker| {
            let lift = maker.floats(&[[0.0_f32, 0.0, 3.0]; 3]);
            maker.json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": lift}]);
            maker.json["meshes"][0]["weights"] = json!([2]);
        },
        |scene| corners(scene, 0)[0].z == 6.0,
    );
    row(
        "`KHR_node_visibility`",
        |maker| {
            maker.push(
                "nodes",
                json!({"mesh": 0, "extensions": {"KHR_node_visibility": {"visible": false}}}),
            );
            maker.json["scenes"][0]["nodes"] = json!([0, 1]);
        },
        |scene| scene.objects.len() == 2,
    );
    row(
        "`baseColorFactor`, `baseColorTexture`, `metallicFactor`, `roughnessFactor`",
        |maker| {
            maker.material(json!({"pbrMetallicRoughness": {"roughnessFactor": 0.25}}));
        },
        |scene| scene.objects[0].material.roughness == 0.25,
    );
    row(
        "`KHR_texture_transform`",
        |maker| {
            let uvs = maker.floats(&[[0.0_f32, 0.0]; 3]);
            maker.attribute("TEXCOORD_0", uvs);
            let texture = maker.texture(&image::RgbaImage::new(1, 1));
            maker.material(
                json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": texture,
            "extensions": {"KHR_texture_transform": {"offset": [3, 0]}}}}}),
            );
        },
        |scene| scene.objects[0].mesh.uvs[0].x == 3.0,
    );
    row(
        "`COLOR_0`",
        |maker| {
            let colors = maker.floats(&[[0.5_f32, 0.5, 0.5]; 3]);
            maker.attribute("COLOR_0", colors);
        },
        |scene| scene.objects[0].mesh.colors[0].x == 0.5,
    );
    row(
        "`alphaMode` `MASK`",
        |maker| {
            maker.material(json!({"alphaMode": "MASK", "alphaCutoff": 0.75}));
        },
        |scene| scene.objects[0].material.alpha_cutoff == Some(0.75),
    );
    row(
        "`KHR_lights_punctual`",
        |maker| {
            maker.json["extensions"] =
                json!({"KHR_lights_punctual": {"lights": [{"type": "point", "name": "bulb"}]}});
            maker.json["nodes"][0]["name"] = json!(null);
            maker.json["nodes"][0]["extensions"] = json!({"KHR_lights_punctual": {"light": 0}});
        },
        |scene| scene.lights[0].name == "bulb",
    );
    row(
        "`cameras`",
        |maker| {
            maker.json["cameras"] =
                json!([{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.5}}]);
            maker.json["nodes"][0]["camera"] = json!(0);
        },
        |scene| scene.camera.near == 0.5,
    );
    row(
        "attributes of an application's own (`_NAME`), `extras`",
        |maker| {
            let own = maker.accessor("SCALAR", F32, 1, &[0; 4]);
            maker.attribute("_FEATURE_ID_0", own);
            maker.json["extras"] = json!({"extensions": {"none": {}}});
        },
        anything,
    );

    row(
        "`alphaMode BLEND`",
        |maker| {
            maker.material(json!({"alphaMode": "BLEND", "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0.6]}}));
        },
        |scene| scene.objects[0].material.alpha_cutoff == Some(0.5),
    );
    row(
        "`doubleSided: false`",
        |maker| maker.material(json!({"doubleSided": false})),
        anything,
    );
    row(
        "`normalTexture`",
        |maker| maker.material(json!({"normalTexture": {"index": 0}})),
        anything,
    );
    row(
        "`occlusionTexture`",
        |maker| maker.material(json!({"occlusionTexture": {"index": 0}})),
        anything,
    );
    row(
        "`emissiveTexture`",
        |maker| maker.material(json!({"emissiveTexture": {"index": 0}})),
        anything,
    );
    row(
        "`emissiveFactor`",
        |maker| maker.material(json!({"emissiveFactor": [0, 1, 0]})),
        anything,
    );
    row(
        "`metallicRoughnessTexture`",
        |maker| {
            maker.material(
                json!({"pbrMetallicRoughness": {"metallicRoughnessTexture": {"index": 0}}}),
            );
        },
        anything,
    );
    row(
        "`minFilter`",
        |maker| {
            maker.push("samplers", json!({"minFilter": 9728}));
        },
        anything,
    );
    row(
        "`textures without a source`",
        |maker| {
            maker.push("textures", json!({}));
            maker.material(json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}));
        },
        |scene| scene.objects[0].material.base_color_texture.is_none(),
    );
    row(
        "`a missing TEXCOORD_0`",
        |maker| {
            let texture = maker.texture(&image::RgbaImage::new(1, 1));
            maker.material(
                json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": texture}}}),
            );
        },
        anything,
    );
    row(
        "`points`",
        |maker| add_primitive(maker, 0),
        |scene| scene.objects.len() == 2,
    );
    row(
        "`lines`",
        |maker| add_primitive(maker, 3),
        |scene| scene.objects.len() == 2,
    );
    row(
        "`primitives without POSITION`",
        |maker| {
            let primitives = &mut maker.json["meshes"][0]["primitives"];
            primitives
                .as_array_mut()
                .expect("a list")
                .push(json!({"attributes": {}}));
        },
        anything,
    );
    row("`COLOR_1`", |maker| maker.attribute("COLOR_1", 0), anything);
    row(
        "`animations`",
        |maker| {
            maker.push("animations", json!({"channels": "any"}));
        },
        anything,
    );
    row(
        "`scenes`",
        |maker| {
            maker.push("scenes", json!({}));
        },
        anything,
    );
    row(
        "`rotation of length 0`",
        |maker| maker.json["nodes"][0]["rotation"] = json!([0, 0, 0, 0]),
        anything,
    );
    row(
        "`EXT_mesh_gpu_instancing of a mesh with a skin`",
        |maker| {
            add_skin(maker);
            maker.push("nodes", json!({}));
            maker.json["nodes"][0]["extensions"] =
                json!({"EXT_mesh_gpu_instancing": {"attributes": {}}});
        },
        anything,
    );
    row(
        "`outerConeAngle beyond 89 degrees`",
        |maker| {
            maker.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [
            {"type": "spot", "spot": {"outerConeAngle": 1.57}}]}});
            maker.json["nodes"][0]["extensions"] = json!({"KHR_lights_punctual": {"light": 0}});
        },
        anything,
    );
    row(
        "`KHR_lights_punctual without a direction`",
        |maker| {
            maker.json["extensions"] =
                json!({"KHR_lights_punctual": {"lights": [{"type": "spot"}]}});
            let node =
                json!({"scale": [0, 0, 0], "extensions": {"KHR_lights_punctual": {"light": 0}}});
            let node = maker.push("nodes", node);
            maker.json["scenes"][0]["nodes"] = json!([0, node]);
        },
        |scene| scene.lights[0].name == "sun",
    );
    row(
        "`cameras without a direction`",
        |maker| {
            maker.json["cameras"] =
                json!([{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.5}}]);
            let node = maker.push("nodes", json!({"scale": [0, 0, 0], "camera": 0}));
            maker.json["scenes"][0]["nodes"] = json!([0, node]);
        },
        anything,
    );
    row(
        "`KHR_materials_transmission`",
        |maker| {
            maker.material(
                json!({"extensions": {"KHR_materials_transmission": {"transmissionFactor": 1}}}),
            );
        },
        anything,
    );
    row(
        "`KHR_materials_variants`",
        |maker| {
            maker.json["extensions"] =
                json!({"KHR_materials_variants": {"variants": [{"name": "red"}]}});
        },
        anything,
    );
    row(
        "`KHR_made_up`",
        |maker| maker.json["extensionsUsed"] = json!(["KHR_made_up"]),
        anything,
    );

    row(
        "`KHR_draco_mesh_compression`",
        |maker| require(maker, "KHR_draco_mesh_compression"),
        anything,
    );
    row(
        "`EXT_meshopt_compression`",
        |maker| require(maker, "EXT_meshopt_compression"),
        anything,
    );
    row(
        "`KHR_texture_basisu`",
        |maker| require(maker, "KHR_texture_basisu"),
        anything,
    );
    row(
        "`EXT_texture_webp`",
        |maker| require(maker, "EXT_texture_webp"),
        anything,
    );
    row(
        "`KHR_made_up`, if required",
        |maker| require(maker, "KHR_made_up"),
        anything,
    );
    row(
        "`asset.version` but 2",
        |maker| maker.json["asset"]["version"] = json!("1.0"),
        anything,
    );
    rows
}

fn require(maker: &mut Maker, name: &str) {
    maker.json["extensionsRequired"] = json!([name]);
}

fn add_skin(maker: &mut Maker) {
    let joints = maker.accessor("VEC4", U8, 3, &[0; 12]);
    let weights = maker.floats(&[[1.0_f32, 0.0, 0.0, 0.0]; 3]);
    maker.attribute("JOINTS_0", joints);
    maker.attribute("WEIGHTS_0", weights);
    maker.push("skins", json!({"joints": [1]}));
    maker.json["nodes"][0]["skin"] = json!(0);
}

fn add_primitive(maker: &mut Maker, mode: u32) {
    let primitives = &mut maker.json["meshes"][0]["primitives"];
    let primitive = json!({"attributes": {"POSITION": 0}, "mode": mode});
    primitives.as_array_mut().expect("a list").push(primitive);
}

#[test]
fn each_row_of_the_table_holds() {
    let mut rows = rows();
    for line in TABLE.lines().filter(|line| line.starts_with("| ")).skip(2) {
        let cells: Vec<_> = line.trim_matches('|').split(" | ").map(str::trim).collect();
        let [name, outcome, _] = cells[..] else {
            panic!("three cells a row: {line}")
        };
        let outcome = match outcome {
            "done" => Outcome::Done,
            "told" => Outcome::Told,
            "refused" => Outcome::Refused,
            _ => panic!("no outcome: {line}"),
        };
        let (add, seen) = rows
            .remove(name)
            .unwrap_or_else(|| panic!("no file for {name}"));
        let mut maker = triangle();
        add(&mut maker);
        let plain = name.trim_matches('`');
        match maker.load() {
            Err(error) => {
                assert_eq!(outcome, Outcome::Refused, "{error}");
                let said = error.to_string();
                let expected = plain.split('`').next().unwrap_or_default();
                let version = expected == "asset.version" && said.contains("it is glTF 1.0");
                assert!(said.contains(expected) || version, "{said}");
            }
            Ok(scene) => {
                let told = left_out(&scene);
                let expected: &[(&str, usize)] = if outcome == Outcome::Told {
                    &[(plain, 1)]
                } else {
                    &[]
                };
                assert_eq!(told, expected, "{name}");
                assert_ne!(outcome, Outcome::Refused, "{name}");
                assert!(seen(&scene), "{name}");
            }
        }
    }
    let missing: Vec<_> = rows.keys().collect();
    assert!(missing.is_empty(), "not in the table: {missing:?}");
}

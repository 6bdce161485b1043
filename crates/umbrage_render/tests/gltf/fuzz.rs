//! Damaged files are read or refused; none makes the reader panic or run out of memory.

use serde_json::{Value, json};
use tempfile::TempDir;

use crate::maker::{Maker, U8, load_in, triangle};

/// A file that has every kind of element that is read.
fn rich() -> Maker {
    let mut maker = triangle();
    let normals = maker.floats(&[[0.0, 0.0, 1.0]; 3]);
    let uvs = maker.floats(&[[0.0_f32, 0.5]; 3]);
    let colors = maker.floats(&[[0.5_f32, 0.5, 0.5, 0.5]; 3]);
    let joints = maker.accessor("VEC4", U8, 3, &[0; 12]);
    let weights = maker.floats(&[[1.0_f32, 0.0, 0.0, 0.0]; 3]);
    let attributes = [
        ("NORMAL", normals),
        ("TEXCOORD_0", uvs),
        ("COLOR_0", colors),
        ("JOINTS_0", joints),
        ("WEIGHTS_0", weights),
    ];
    for (name, accessor) in attributes {
        maker.attribute(name, accessor);
    }
    let indices = maker.accessor("SCALAR", U8, 3, &[0, 1, 2]);
    maker.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    let (places, values) = (maker.view(&[2]), maker.view(&[0; 12]));
    let target = maker.push("accessors", json!({"componentType": 5126, "count": 3, "type": "VEC3", "sparse":
        {"count": 1, "indices": {"bufferView": places, "componentType": U8}, "values": {"bufferView": values}}}));
    maker.json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": target}]);
    maker.json["meshes"][0]["weights"] = json!([0.5]);
    let texture = maker.texture(&image::RgbaImage::new(2, 2));
    maker.material(json!({
        "alphaMode": "MASK", "alphaCutoff": 0.25,
        "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0.5], "baseColorTexture": {"index": texture,
            "extensions": {"KHR_texture_transform": {"offset": [0.5, 0], "rotation": 1, "scale": [2, 2]}}}},
    }));
    let inverse = maker.floats(&[[1.0_f32; 16]]);
    maker.push(
        "skins",
        json!({"joints": [1], "inverseBindMatrices": inverse}),
    );
    let instances = maker.floats(&[[0.0_f32, 1.0, 2.0]; 2]);
    maker.push(
        "cameras",
        json!({"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1, "zfar": 9}}),
    );
    maker.json["extensions"] =
        json!({"KHR_lights_punctual": {"lights": [{"type": "spot", "range": 9}]}});
    maker.json["nodes"] = json!([
        {"mesh": 0, "children": [1], "rotation": [0, 0, 0, 1], "extensions":
            {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": instances}}}},
        {"mesh": 0, "skin": 0, "camera": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1],
            "extensions": {"KHR_lights_punctual": {"light": 0}}},
    ]);
    maker
}

/// A generator of numbers below a bound (a linear congruence).
fn random(seed: u32) -> impl FnMut(usize) -> usize {
    let mut state = seed;
    move |bound| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as usize % bound.max(1)
    }
}

#[test]
fn damaged_bytes_are_read_or_refused() {
    let folder = TempDir::new().expect("a folder");
    let whole = rich().binary();
    load_in(folder.path(), "whole.glb", &whole).expect("a model");
    let mut random = random(1);
    let mut read = 0;
    for _ in 0..3000 {
        let mut bytes = whole.clone();
        for _ in 0..=random(3) {
            let place = random(bytes.len());
            match random(4) {
                0 => bytes[place] = random(256) as u8,
                1 => bytes[place] ^= 1 << random(8),
                2 => bytes.truncate(place.max(1)),
                _ => bytes[place] = b"0123456789-.eE\"{}[],:"[random(21)],
            }
        }
        read += usize::from(load_in(folder.path(), "model.glb", &bytes).is_ok());
    }
    assert!(
        read > 100,
        "{read} were read: too few tell of what follows the JSON"
    );
}

/// All values below `value`, by their pointers.
fn pointers(value: &Value, at: &str, found: &mut Vec<String>) {
    found.push(at.to_owned());
    match value {
        Value::Array(elements) => {
            for (index, element) in elements.iter().enumerate() {
                pointers(element, &format!("{at}/{index}"), found);
            }
        }
        Value::Object(members) => {
            for (name, member) in members {
                pointers(member, &format!("{at}/{name}"), found);
            }
        }
        _ => {}
    }
}

#[test]
fn other_values_are_read_or_refused() {
    let maker = rich();
    let mut places = Vec::new();
    pointers(&maker.json, "", &mut places);
    let values = [
        json!(null),
        json!(true),
        json!(-1),
        json!(0),
        json!(1),
        json!(2),
        json!(0.5),
        json!(4_000_000_000_u32),
        json!(u64::MAX),
        json!(1e39),
        json!(1e308),
        json!(-1e308),
        json!("text"),
        json!([]),
        json!({}),
        json!([0, 0, 0]),
        json!([1, 2, 3, 4]),
        json!([{}]),
    ];
    let (mut read, mut refused) = (0, 0);
    for place in &places {
        for value in &values {
            let mut changed = maker.clone();
            *changed.json.pointer_mut(place).expect("a value") = value.clone();
            if !changed.json.is_object() {
                continue;
            }
            match changed.load() {
                Ok(_) => read += 1,
                Err(error) => {
                    refused += 1;
                    let said = error.to_string();
                    assert!(
                        said.contains("model.gltf: ") && !said.contains('\n'),
                        "{said}"
                    );
                }
            }
        }
    }
    assert!(
        read > 100 && refused > 1000,
        "{read} read, {refused} refused"
    );
    // Without one of its members.
    for place in &places {
        let Some((parent, name)) = place.rsplit_once('/') else {
            continue;
        };
        let mut changed = maker.clone();
        if let Some(Value::Object(members)) = changed.json.pointer_mut(parent) {
            members.remove(name);
            let _: Result<_, _> = changed.load();
        }
    }
}

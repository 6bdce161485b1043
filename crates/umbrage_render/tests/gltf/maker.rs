//! Makes glTF files.

use std::{fs, path::Path};

use base64::{Engine, prelude::BASE64_STANDARD};
use glam::DVec3;
use serde_json::{Value, json};
use tempfile::TempDir;
use umbrage_render::{Scene, SceneError};

pub(crate) const I8: u32 = 5120;
pub(crate) const U8: u32 = 5121;
pub(crate) const I16: u32 = 5122;
pub(crate) const U16: u32 = 5123;
pub(crate) const U32: u32 = 5125;
pub(crate) const F32: u32 = 5126;

/// A glTF file in the making, with one buffer.
#[derive(Clone)]
pub(crate) struct Maker {
    pub(crate) json: Value,
    pub(crate) bytes: Vec<u8>,
}

/// A file of one triangle in the plane z = 0, with a metre along x and y, at its only node.
pub(crate) fn triangle() -> Maker {
    let mut maker = Maker {
        json: json!({
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0, "name": "tri"}],
        }),
        bytes: Vec::new(),
    };
    let positions = maker.floats(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    maker.push(
        "meshes",
        json!({"primitives": [{"attributes": {"POSITION": positions}}]}),
    );
    maker
}

impl Maker {
    /// Adds to a list at the root; its place there.
    pub(crate) fn push(&mut self, list: &str, value: Value) -> usize {
        if self.json.get(list).is_none() {
            self.json[list] = json!([]);
        }
        let list = self.json[list].as_array_mut().expect("a list");
        list.push(value);
        list.len() - 1
    }

    /// Adds bytes to the buffer; the view's place.
    pub(crate) fn view(&mut self, bytes: &[u8]) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let view = json!({"buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len()});
        self.bytes.extend(bytes);
        self.push("bufferViews", view)
    }

    /// Adds `count` elements of a type such as `VEC3`; the accessor's place.
    pub(crate) fn accessor(
        &mut self,
        kind: &str,
        component: u32,
        count: usize,
        bytes: &[u8],
    ) -> usize {
        let view = self.view(bytes);
        let accessor =
            json!({"bufferView": view, "componentType": component, "count": count, "type": kind});
        self.push("accessors", accessor)
    }

    pub(crate) fn floats<const N: usize>(&mut self, vectors: &[[f32; N]]) -> usize {
        let bytes: Vec<u8> = vectors
            .iter()
            .flatten()
            .flat_map(|x| x.to_le_bytes())
            .collect();
        let kind = match N {
            1 => "SCALAR",
            2 => "VEC2",
            3 => "VEC3",
            4 => "VEC4",
            _ => "MAT4",
        };
        self.accessor(kind, F32, vectors.len(), &bytes)
    }

    /// The attributes of the only primitive.
    pub(crate) fn attribute(&mut self, name: &str, accessor: usize) {
        self.json["meshes"][0]["primitives"][0]["attributes"][name] = json!(accessor);
    }

    /// Gives the only primitive a material.
    pub(crate) fn material(&mut self, material: Value) {
        let place = self.push("materials", material);
        self.json["meshes"][0]["primitives"][0]["material"] = json!(place);
    }

    /// Adds a texture of the given picture; its place.
    pub(crate) fn texture(&mut self, picture: &image::RgbaImage) -> usize {
        let view = self.view(&png(picture));
        let image = self.push(
            "images",
            json!({"bufferView": view, "mimeType": "image/png"}),
        );
        let sampler = self.push("samplers", json!({"magFilter": 9728}));
        self.push("textures", json!({"source": image, "sampler": sampler}))
    }

    /// The file's text, with its buffer in it.
    pub(crate) fn text(&self) -> String {
        let mut json = self.json.clone();
        if json.get("buffers").is_none() {
            let uri = format!(
                "data:application/octet-stream;base64,{}",
                BASE64_STANDARD.encode(&self.bytes)
            );
            json["buffers"] = json!([{"uri": uri, "byteLength": self.bytes.len()}]);
        }
        json.to_string()
    }

    /// The file in binary.
    pub(crate) fn binary(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        json["buffers"] = json!([{"byteLength": self.bytes.len()}]);
        let mut text = json.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut bytes = self.bytes.clone();
        bytes.resize(bytes.len().next_multiple_of(4), 0);
        glb(&[(b"JSON", &text), (b"BIN\0", &bytes)])
    }

    pub(crate) fn load(&self) -> Result<Scene, SceneError> {
        let folder = TempDir::new().expect("a folder");
        load_in(folder.path(), "model.gltf", self.text().as_bytes())
    }

    pub(crate) fn scene(&self) -> Scene {
        self.load().expect("a model")
    }

    pub(crate) fn refusal(&self) -> String {
        self.load().expect_err("refused").to_string()
    }
}

/// Loads what `bytes` are, written to a file of this name.
pub(crate) fn load_in(folder: &Path, name: &str, bytes: &[u8]) -> Result<Scene, SceneError> {
    let path = folder.join(name);
    fs::write(&path, bytes).expect("written");
    Scene::load(path)
}

/// A binary file of these chunks.
pub(crate) fn glb(chunks: &[(&[u8; 4], &[u8])]) -> Vec<u8> {
    let mut file = Vec::new();
    for (kind, bytes) in chunks {
        file.extend((bytes.len() as u32).to_le_bytes());
        file.extend(*kind);
        file.extend(*bytes);
    }
    let mut header = b"glTF\x02\0\0\0".to_vec();
    header.extend((file.len() as u32 + 12).to_le_bytes());
    header.extend(file);
    header
}

pub(crate) fn png(picture: &image::RgbaImage) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    picture
        .write_to(&mut bytes, image::ImageFormat::Png)
        .expect("encoded");
    bytes.into_inner()
}

/// Where the corners of the object's triangles stand in the world.
pub(crate) fn corners(scene: &Scene, object: usize) -> Vec<DVec3> {
    let object = &scene.objects[object];
    let place = |index: &u32| {
        let position = object.mesh.positions[*index as usize].as_dvec3();
        object.transform.transform_point3(position)
    };
    object.mesh.indices.iter().map(place).collect()
}

/// The names of what was left out, with how often.
pub(crate) fn left_out(scene: &Scene) -> Vec<(&str, usize)> {
    scene
        .left_out
        .iter()
        .map(|left| (left.feature.as_str(), left.places))
        .collect()
}

pub(crate) fn assert_near(found: &[DVec3], expected: &[[f64; 3]]) {
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for (found, expected) in found.iter().zip(expected) {
        assert!(
            found.abs_diff_eq(DVec3::from(*expected), 1e-6),
            "{found} is not {expected:?}"
        );
    }
}

//! Finds the features of a glTF file that the model leaves out, and tells them by name.

use std::{
    cell::RefCell,
    collections::{BTreeMap, BTreeSet},
    path::Path,
};

use serde_json::Value;

use super::{LeftOut, SceneError, document::Document};

/// The extensions that a model is read with.
const DONE: [&str; 5] = [
    "EXT_mesh_gpu_instancing",
    "KHR_lights_punctual",
    "KHR_mesh_quantization",
    "KHR_node_visibility",
    "KHR_texture_transform",
];

/// Features left out so far, by name: the replacement that is shown, and where the file has the feature.
#[derive(Default)]
pub(super) struct Notes(RefCell<BTreeMap<String, (String, BTreeSet<String>)>>);

impl Notes {
    /// Notes that `place` says `feature`; each place counts once.
    pub(super) fn tell(&self, feature: &str, instead: &str, place: impl Into<String>) {
        let mut notes = self.0.borrow_mut();
        let (_, places) = notes
            .entry(feature.to_owned())
            .or_insert_with(|| (instead.to_owned(), BTreeSet::new()));
        places.insert(place.into());
    }

    /// All that was noted of the file at `path`, by name.
    pub(super) fn finish(self, path: &Path) -> Vec<LeftOut> {
        let notes = self.0.into_inner().into_iter();
        let left_out = notes.filter_map(|(feature, (instead, places))| {
            LeftOut::new(path, &feature, places.len(), &instead)
        });
        left_out.collect()
    }
}

/// Refuses a file that must not be read without an extension which is not known.
pub(super) fn check_required(document: &Document<'_>) -> Result<(), SceneError> {
    let required = document.list("extensionsRequired").iter();
    let names = required.map(|name| name.as_str().unwrap_or("a name that is no text"));
    let mut unknown = names.filter(|name| !DONE.contains(name));
    let Some(name) = unknown.next() else {
        return Ok(());
    };
    let problem = format!("the model cannot be read without {name}, which is not supported");
    let remedy = match name {
        "KHR_draco_mesh_compression" | "EXT_meshopt_compression" | "KHR_meshopt_compression" => {
            "export it again without compression, or unpack it (`gltf-transform copy` does)"
        }
        "KHR_texture_basisu" | "EXT_texture_webp" | "EXT_texture_avif" | "MSFT_texture_dds" => {
            "export it again with PNG or JPEG textures"
        }
        _ => "export it again without the extension",
    };
    let place = "extensionsRequired";
    Err(SceneError::invalid(document.path, place, problem, remedy))
}

/// Notes the features of the file as a whole; `scene` is the number of the scene that is read. Features that show
/// only when an element is decoded are noted there.
pub(super) fn note(document: &Document<'_>, scene: usize, notes: &Notes) {
    let each = |list: &'static str| {
        let elements = document.list(list).iter().enumerate();
        elements.map(move |(index, element)| (format!("{list}[{index}]"), element))
    };
    for (place, _) in each("animations") {
        notes.tell("animations", "the stored pose is drawn", place);
    }
    let others = each("scenes")
        .enumerate()
        .filter(|(index, _)| *index != scene);
    for (_, (place, _)) in others {
        notes.tell("scenes", "the default scene alone is drawn", place);
    }
    for (place, material) in each("materials") {
        note_material(material, &place, notes);
    }
    for (place, sampler) in each("samplers") {
        const SMOOTH: u64 = 9987;
        if sampler
            .get("minFilter")
            .and_then(Value::as_u64)
            .is_some_and(|filter| filter != SMOOTH)
        {
            let instead = "far textures are blended between texels and mipmaps";
            notes.tell("minFilter", instead, place);
        }
    }
    for (place, mesh) in each("meshes") {
        let primitives = mesh
            .get("primitives")
            .and_then(Value::as_array)
            .into_iter()
            .flatten();
        for (number, primitive) in primitives.enumerate() {
            note_primitive(primitive, &format!("{place}.primitives[{number}]"), notes);
        }
    }
    let mut extensions = BTreeMap::new();
    find_extensions(&document.json, "", &mut extensions);
    for name in document
        .list("extensionsUsed")
        .iter()
        .filter_map(Value::as_str)
    {
        let places: &mut Vec<String> = extensions.entry(name).or_default();
        if places.is_empty() {
            places.push("extensionsUsed".to_owned());
        }
    }
    for (name, places) in extensions {
        for place in places.into_iter().filter(|_| !DONE.contains(&name)) {
            notes.tell(name, without(name), place);
        }
    }
}

fn note_material(material: &Value, place: &str, notes: &Notes) {
    let instead = "surfaces have their colour, metalness and roughness alone";
    let textures = ["normalTexture", "occlusionTexture", "emissiveTexture"];
    for name in textures
        .into_iter()
        .filter(|name| material.get(name).is_some())
    {
        notes.tell(name, instead, place);
    }
    if material
        .pointer("/pbrMetallicRoughness/metallicRoughnessTexture")
        .is_some()
    {
        notes.tell("metallicRoughnessTexture", instead, place);
    }
    let emissive = material.get("emissiveFactor").and_then(Value::as_array);
    if emissive.is_some_and(|factors| factors.iter().any(|f| f.as_f64() != Some(0.0))) {
        notes.tell("emissiveFactor", "nothing but lights shines", place);
    }
    if material.get("doubleSided") == Some(&Value::Bool(false)) {
        let instead = "both sides of a surface are seen and cast";
        notes.tell("doubleSided: false", instead, place);
    }
}

fn note_primitive(primitive: &Value, place: &str, notes: &Notes) {
    let is_drawn = match primitive.get("mode").and_then(Value::as_f64) {
        Some(0.0) => {
            notes.tell("points", "triangles alone are drawn", place);
            false
        }
        Some(1.0..=3.0) => {
            notes.tell("lines", "triangles alone are drawn", place);
            false
        }
        _ => true,
    };
    let attributes = primitive.get("attributes").and_then(Value::as_object);
    let has = |name: &str| attributes.is_some_and(|attributes| attributes.contains_key(name));
    if is_drawn && !has("POSITION") {
        notes.tell(
            "primitives without POSITION",
            "nothing is drawn of them",
            place,
        );
    }
    let further = |name: &&String| name.starts_with("COLOR_") && *name != "COLOR_0";
    for name in attributes
        .into_iter()
        .flat_map(|a| a.keys())
        .filter(further)
    {
        notes.tell(name, "COLOR_0 alone is drawn", place);
    }
}

/// Where each extension is used, by its name. `extras` are skipped: their contents are the application's own.
fn find_extensions<'a>(value: &'a Value, place: &str, found: &mut BTreeMap<&'a str, Vec<String>>) {
    match value {
        Value::Array(elements) => {
            for (index, element) in elements.iter().enumerate() {
                find_extensions(element, &format!("{place}[{index}]"), found);
            }
        }
        Value::Object(members) => {
            for (name, member) in members.iter().filter(|(name, _)| *name != "extras") {
                if let ("extensions", Value::Object(extensions)) = (name.as_str(), member) {
                    for name in extensions.keys() {
                        found.entry(name).or_default().push(place.to_owned());
                    }
                }
                find_extensions(member, &format!("{place}.{name}"), found);
            }
        }
        _ => {}
    }
}

/// The replacement that is shown for an extension.
fn without(name: &str) -> &'static str {
    match name {
        "KHR_draco_mesh_compression" | "EXT_meshopt_compression" | "KHR_meshopt_compression" => {
            "the data without compression is read"
        }
        "KHR_texture_basisu" | "EXT_texture_webp" | "EXT_texture_avif" | "MSFT_texture_dds" => {
            "the PNG or JPEG beside it is read"
        }
        "KHR_animation_pointer" => "the stored pose is drawn",
        "KHR_materials_variants" => "each surface has the material that it has without",
        "KHR_materials_unlit" => "surfaces are lit",
        "KHR_materials_emissive_strength" => "nothing but lights shines",
        "KHR_materials_transmission" | "KHR_materials_volume" => "surfaces let no light through",
        _ if name.starts_with("KHR_materials_") => {
            "surfaces have their colour, metalness and roughness alone"
        }
        _ => "the model is read without it",
    }
}

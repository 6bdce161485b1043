//! The nodes of a glTF scene: what stands where.

use std::collections::{BTreeMap, BTreeSet};

use glam::{DAffine3, DMat4, DQuat, DVec3, DVec4};
use serde::Deserialize;

use super::{
    Reader, SceneError,
    document::{Document, Whole},
    left_out::Notes,
};

#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct Node {
    pub(super) name: Option<String>,
    children: Vec<Whole>,
    pub(super) mesh: Option<Whole>,
    pub(super) skin: Option<Whole>,
    pub(super) weights: Option<Vec<f64>>,
    pub(super) camera: Option<Whole>,
    matrix: Option<[f64; 16]>,
    translation: Option<[f64; 3]>,
    rotation: Option<[f64; 4]>,
    scale: Option<[f64; 3]>,
    pub(super) extensions: NodeExtensions,
}

#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct NodeExtensions {
    #[serde(rename = "EXT_mesh_gpu_instancing")]
    pub(super) instancing: Option<Instancing>,
    #[serde(rename = "KHR_lights_punctual")]
    pub(super) light: Option<LightNumber>,
    #[serde(rename = "KHR_node_visibility")]
    visibility: Option<Visibility>,
}

#[derive(Deserialize)]
pub(super) struct Instancing {
    #[serde(default)]
    attributes: BTreeMap<String, Whole>,
}

#[derive(Deserialize)]
pub(super) struct LightNumber {
    pub(super) light: Whole,
}

#[derive(Deserialize)]
struct Visibility {
    #[serde(default = "seen")]
    visible: bool,
}

fn seen() -> bool {
    true
}

#[derive(Deserialize)]
struct SceneFile {
    #[serde(default)]
    nodes: Vec<Whole>,
}

/// A node of the scene.
pub(super) struct Placed {
    pub(super) place: String,
    pub(super) node: Node,
    /// Node to scene.
    pub(super) world: DAffine3,
    /// Whether it and all above it are.
    pub(super) is_visible: bool,
}

/// The nodes of the scene in the file's order, and where each stands by its number.
pub(super) type Nodes = (Vec<Placed>, BTreeMap<Whole, DAffine3>);

/// The number of the scene that is read.
pub(super) fn scene(document: &Document<'_>) -> Result<usize, SceneError> {
    let Some(chosen) = document.json.get("scene") else {
        return Ok(0);
    };
    let chosen =
        Whole::deserialize(chosen).map_err(|error| document.invalid("scene", error.to_string()))?;
    document.element::<SceneFile>("scenes", chosen, "scene")?;
    Ok(chosen.place())
}

/// The nodes of the scene with the number `scene`; of a file without scenes, all.
pub(super) fn nodes(
    document: &Document<'_>,
    scene: usize,
    notes: &Notes,
) -> Result<Nodes, SceneError> {
    let by = format!("scenes[{scene}]");
    let roots = match document.list("scenes").is_empty() {
        true => {
            let parents = parents(document);
            let all = (0..document.list("nodes").len() as u64).map(Whole);
            all.filter(|node| !parents.contains_key(node)).collect()
        }
        false => {
            document
                .element::<SceneFile>("scenes", Whole(scene as u64), &by)?
                .nodes
        }
    };
    let mut placed = Vec::new();
    let mut worlds = BTreeMap::new();
    // Last in, first out: pushed backwards, nodes come in the file's order.
    let start = roots.into_iter().rev();
    let mut stack: Vec<_> = start
        .map(|root| (root, DAffine3::IDENTITY, true, by.clone()))
        .collect();
    while let Some((index, parent, is_above_visible, by)) = stack.pop() {
        let mut node: Node = document.element("nodes", index, &by)?;
        let place = format!("nodes[{}]", index.0);
        let world = parent * local(&node, &place, notes);
        if !world.is_finite() {
            return Err(document.invalid(&place, "its transform is not finite"));
        }
        if worlds.insert(index, world).is_some() {
            let problem = "it is below itself, or below two nodes: nodes must form a tree";
            return Err(document.invalid(&place, problem));
        }
        let own = node.extensions.visibility.as_ref();
        let is_visible = is_above_visible && own.is_none_or(|own| own.visible);
        let children = std::mem::take(&mut node.children).into_iter().rev();
        stack.extend(children.map(|child| (child, world, is_visible, place.clone())));
        placed.push(Placed {
            place,
            node,
            world,
            is_visible,
        });
    }
    if placed.is_empty() {
        return Err(document.invalid("nodes", "the scene has no nodes"));
    }
    Ok((placed, worlds))
}

/// The node above each that has one.
fn parents(document: &Document<'_>) -> BTreeMap<Whole, Whole> {
    let mut parents = BTreeMap::new();
    for (index, node) in document.list("nodes").iter().enumerate() {
        let children = node
            .get("children")
            .and_then(|children| children.as_array());
        for child in children.into_iter().flatten() {
            if let Ok(child) = Whole::deserialize(child) {
                parents.insert(child, Whole(index as u64));
            }
        }
    }
    parents
}

fn local(node: &Node, place: &str, notes: &Notes) -> DAffine3 {
    if let Some(matrix) = &node.matrix {
        return DAffine3::from_mat4(DMat4::from_cols_array(matrix));
    }
    let rotation = DQuat::from_array(node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]));
    DAffine3::from_scale_rotation_translation(
        DVec3::from_array(node.scale.unwrap_or([1.0; 3])),
        unit(rotation, place, notes),
        DVec3::from_array(node.translation.unwrap_or_default()),
    )
}

/// The rotation that a quaternion of any length stands for. A zero stands for none, as it does where a matrix is
/// made of it without a division.
fn unit(rotation: DQuat, place: &str, notes: &Notes) -> DQuat {
    // The longest part is 1 then, so that no square of the others is lost or too large.
    let longest = DVec4::from(rotation).abs().max_element();
    if longest > 0.0 {
        return (rotation * (1.0 / longest)).normalize();
    }
    notes.tell("rotation of length 0", "nothing is turned by it", place);
    DQuat::IDENTITY
}

impl Reader<'_> {
    /// The transform of the node that `by` names, whether the node is in the scene or not.
    pub(super) fn world(&self, index: Whole, by: &str) -> Result<DAffine3, SceneError> {
        if let Some(world) = self.worlds.get(&index) {
            return Ok(*world);
        }
        let parents = self.parents.get_or_init(|| parents(self.document));
        let (mut world, mut next, mut seen) = (DAffine3::IDENTITY, Some(index), BTreeSet::new());
        while let Some(index) = next {
            let node: Node = self.document.element("nodes", index, by)?;
            let place = format!("nodes[{}]", index.0);
            if !seen.insert(index) {
                return Err(self.document.invalid(&place, "it is below itself"));
            }
            world = local(&node, &place, &self.notes) * world;
            next = parents.get(&index).copied();
        }
        Ok(world)
    }

    /// Where a node's mesh stands, from the node: once, or as often as the node says.
    pub(super) fn instances(&self, placed: &Placed) -> Result<Vec<DAffine3>, SceneError> {
        let Some(instancing) = &placed.node.extensions.instancing else {
            return Ok(vec![DAffine3::IDENTITY]);
        };
        let attribute = |name: &str| instancing.attributes.get(name).copied();
        let place = format!("{}.extensions.EXT_mesh_gpu_instancing", placed.place);
        let document = self.document;
        let vectors = |name: &str| {
            let accessor = attribute(name);
            accessor
                .map(|accessor| document.floats::<3>(accessor, &place))
                .transpose()
        };
        let (translations, scales) = (vectors("TRANSLATION")?, vectors("SCALE")?);
        let rotations = attribute("ROTATION");
        let rotations = rotations
            .map(|accessor| document.floats::<4>(accessor, &place))
            .transpose()?;
        let counts = [
            translations.as_ref().map(Vec::len),
            rotations.as_ref().map(Vec::len),
            scales.as_ref().map(Vec::len),
        ];
        let mut counts = counts.into_iter().flatten();
        let Some(count) = counts.next() else {
            // Attributes of an application's own only: they give the number of instances, but no places.
            return Ok(vec![DAffine3::IDENTITY]);
        };
        if let Some(other) = counts.find(|other| *other != count) {
            let problem = format!("its attributes have {count} and {other} elements");
            return Err(document.invalid(&place, problem));
        }
        let at = |list: &Option<Vec<[f32; 3]>>, i: usize, otherwise: DVec3| {
            let vector = list.as_ref().and_then(|list| list.get(i));
            vector.map_or(otherwise, |v| DVec3::from_array(v.map(f64::from)))
        };
        let instance = |i: usize| {
            let rotation = rotations.as_ref().and_then(|list| list.get(i));
            let rotation = rotation.map_or(DQuat::IDENTITY, |quaternion| {
                let quaternion = DQuat::from_array(quaternion.map(f64::from));
                unit(quaternion, &format!("{place}[{i}]"), &self.notes)
            });
            DAffine3::from_scale_rotation_translation(
                at(&scales, i, DVec3::ONE),
                rotation,
                at(&translations, i, DVec3::ZERO),
            )
        };
        Ok((0..count).map(instance).collect())
    }
}

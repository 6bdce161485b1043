//! Reads glTF 2.0 models, text or binary; everything that they declare is checked before it is used.
//!
//! A file's JSON is kept as it is, and each element is decoded when it is read: elements that nothing reads are
//! neither decoded nor checked. Features that move or cut a shadow are read; the file's other features are told by
//! name in the scene's [`left_out`](super::Scene::left_out); a file that requires another extension
//! (`extensionsRequired`) is refused, and the message names it.
#![doc = include_str!("features.md")]

mod accessor;
mod document;
mod left_out;
mod material;
mod mesh;
mod node;
mod view;

use std::{cell::OnceCell, collections::BTreeMap, path::Path, sync::Arc};

use glam::DAffine3;

pub(super) use self::view::{Eye, Lamp};
use self::{
    document::{Document, Whole},
    left_out::Notes,
    mesh::Shapes,
    node::Placed,
};
use super::{LeftOut, Material, Mesh, SceneError, error::read};

/// Contents of a model's file.
pub(super) struct Model {
    /// One at the least.
    pub(super) parts: Vec<Part>,
    pub(super) lamps: Vec<Lamp>,
    pub(super) eyes: Vec<Eye>,
    /// Features of the file that the model leaves out.
    pub(super) left_out: Vec<LeftOut>,
}

/// A part of a model: a mesh in its place.
#[derive(Clone)]
pub(super) struct Part {
    pub(super) name: String,
    pub(super) mesh: Arc<Mesh>,
    pub(super) material: Arc<Material>,
    /// Part to model.
    pub(super) transform: DAffine3,
}

/// The most parts of a model: as instances, they may cost a file nothing.
const MOST_PARTS: usize = 1 << 20;

/// Loads the model at `path`; with texture coordinates even where no texture of its own reads them, if it is to be
/// `textured`.
pub(super) fn load(path: &Path, textured: bool) -> Result<Model, SceneError> {
    let bytes = read(path)?;
    let document = Document::parse(path, &bytes)?;
    let scene = node::scene(&document)?;
    let notes = Notes::default();
    left_out::note(&document, scene, &notes);
    let (nodes, worlds) = node::nodes(&document, scene, &notes)?;
    let reader = Reader {
        document: &document,
        notes,
        worlds,
        parents: OnceCell::new(),
        textured,
    };
    let (mut parts, mut lamps, mut eyes) = (Vec::new(), Vec::new(), Vec::new());
    let mut shapes = Shapes::default();
    for placed in &nodes {
        // A camera counts even where its node is hidden.
        eyes.extend(reader.eye(placed)?);
        if placed.is_visible {
            lamps.extend(reader.light(placed)?);
            reader.parts(placed, &mut shapes, &mut parts)?;
        }
    }
    if parts.is_empty() {
        let remedy = "export a model that has meshes of triangles in its scene";
        let problem = "there is nothing to see";
        return Err(SceneError::invalid(path, "scene", problem, remedy));
    }
    Ok(Model {
        parts,
        lamps,
        eyes,
        left_out: reader.notes.finish(path),
    })
}

/// A file that is being read.
struct Reader<'a> {
    document: &'a Document<'a>,
    notes: Notes,
    /// Where the scene's nodes stand.
    worlds: BTreeMap<Whole, DAffine3>,
    /// The node above each node, for joints outside of the scene.
    parents: OnceCell<BTreeMap<Whole, Whole>>,
    textured: bool,
}

impl Reader<'_> {
    /// Adds what a node shows.
    fn parts(
        &self,
        placed: &Placed,
        shapes: &mut Shapes,
        parts: &mut Vec<Part>,
    ) -> Result<(), SceneError> {
        let node = &placed.node;
        let Some(mesh) = node.mesh else {
            return Ok(());
        };
        let posing = (mesh, node.weights.as_deref(), node.skin);
        let (mesh_name, shapes) = shapes.posed(self, posing, &placed.place)?;
        let name = node.name.as_ref().or(mesh_name.as_ref());
        let name = name.unwrap_or(&placed.place);
        let instances = match node.skin {
            None => self.instances(placed)?,
            Some(_) => {
                if node.extensions.instancing.is_some() {
                    let feature = "EXT_mesh_gpu_instancing of a mesh with a skin";
                    self.notes.tell(feature, "it is drawn once", &placed.place);
                }
                vec![DAffine3::IDENTITY]
            }
        };
        if parts.len() + instances.len() * shapes.len() > MOST_PARTS {
            let problem = format!("the model has more than {MOST_PARTS} meshes and instances");
            return Err(self.document.invalid(&placed.place, problem));
        }
        for instance in instances {
            parts.extend(shapes.iter().map(|shape| Part {
                name: name.clone(),
                mesh: Arc::clone(&shape.mesh),
                material: Arc::clone(&shape.material),
                transform: shape.placed.unwrap_or(placed.world * instance),
            }));
        }
        Ok(())
    }
}

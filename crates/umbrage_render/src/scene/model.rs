//! Reads glTF 2.0 models, text or binary: triangles, their nodes and their materials.
//!
//! Everything is checked before it is read, as the `gltf` crate's own readers trust what a file says.
//! Both sides of a triangle are seen. `BLEND` materials are cut at half their opacity, as nothing
//! here is translucent; skins and morph targets stay in the pose that the meshes have.

use std::{
    borrow::Cow,
    collections::{BTreeMap, BTreeSet, btree_map::Entry},
    path::{Path, PathBuf},
    sync::Arc,
};

use glam::{DAffine3, DMat4, DQuat, DVec3, Vec2, Vec3, Vec4};
use gltf::json::{
    self, Index, Node, Root,
    material::AlphaMode,
    mesh::{Mode, Primitive, Semantic},
    texture::{MagFilter, WrappingMode},
    validation::{Checked, Validate},
};

use super::{Image, Material, Mesh, SceneError, Texture, Wrap, accessor::Buffers, error::read};

/// A part of a model: a mesh in its place.
#[derive(Clone)]
pub(super) struct Part {
    pub(super) name: String,
    pub(super) mesh: Arc<Mesh>,
    pub(super) material: Arc<Material>,
    /// Part to model.
    pub(super) transform: DAffine3,
}

/// Loads the parts of the model at `path`; one at the least.
pub(super) fn load(path: &Path) -> Result<Vec<Part>, SceneError> {
    let bytes = read(path)?;
    let (root, blob) = parse(path, &bytes)?;
    validate(path, &root)?;
    let data = load_buffers(path, &root, blob)?;
    let reader = Reader {
        path,
        root: &root,
        buffers: Buffers {
            path,
            root: &root,
            data,
        },
    };
    let images = (0..root.images.len())
        .map(|i| reader.image(i))
        .collect::<Result<Vec<_>, _>>()?;
    let materials = reader.materials(&images)?;
    let mut meshes = BTreeMap::new();
    let mut parts = Vec::new();
    for (node, transform) in reader.nodes()? {
        let Some(index) = root.nodes[node].mesh else {
            continue;
        };
        if let Entry::Vacant(vacant) = meshes.entry(index) {
            vacant.insert(reader.mesh(index, &materials)?);
        }
        let name = root.nodes[node]
            .name
            .clone()
            .or_else(|| root.get(index)?.name.clone());
        let name = name.unwrap_or_else(|| format!("nodes[{node}]"));
        for (mesh, material) in meshes.get(&index).into_iter().flatten() {
            let (mesh, material) = (Arc::clone(mesh), Arc::clone(material));
            parts.push(Part {
                name: name.clone(),
                mesh,
                material,
                transform,
            });
        }
    }
    if parts.is_empty() {
        let remedy = "export a model that has meshes of triangles in its scene";
        return Err(SceneError::invalid(
            path,
            "scene",
            "there is nothing to see",
            remedy,
        ));
    }
    Ok(parts)
}

/// A binary file's own buffer.
type Blob<'a> = Option<Cow<'a, [u8]>>;

fn parse<'a>(path: &Path, bytes: &'a [u8]) -> Result<(Root, Blob<'a>), SceneError> {
    let broken = |message: String| {
        SceneError::invalid(
            path,
            "file",
            message,
            "the file is damaged or no glTF 2.0; export it again",
        )
    };
    if !bytes.starts_with(b"glTF") {
        let root = Root::from_slice(bytes).map_err(|error| broken(error.to_string()))?;
        return Ok((root, None));
    }
    // The binary reader subtracts the header's size from the length without a look.
    let length = bytes
        .get(8..12)
        .map_or(0, |l| u32::from_le_bytes([l[0], l[1], l[2], l[3]]));
    if length < 12 {
        return Err(broken(format!(
            "its header says that it is {length} bytes long"
        )));
    }
    let glb = gltf::Glb::from_slice(bytes).map_err(|error| broken(error.to_string()))?;
    let root = Root::from_slice(&glb.json).map_err(|error| broken(error.to_string()))?;
    Ok((root, glb.bin))
}

fn validate(path: &Path, root: &Root) -> Result<(), SceneError> {
    let remedy =
        "export the model again, without extensions that must be understood (such as Draco)";
    // The validator indexes positions before it checks their accessor.
    for (index, mesh) in root.meshes.iter().enumerate() {
        let accessors = mesh.primitives.iter().flat_map(|p| p.attributes.values());
        if let Some(missing) = accessors.into_iter().find(|a| root.get(**a).is_none()) {
            let problem = format!(
                "it names accessor {missing}, but there are {}",
                root.accessors.len()
            );
            return Err(SceneError::invalid(
                path,
                format!("meshes[{index}]"),
                problem,
                remedy,
            ));
        }
    }
    let mut faults = Vec::new();
    root.validate(root, json::Path::new, &mut |path, error| {
        faults.push((path().to_string(), error.to_string()));
    });
    match faults.first() {
        None => Ok(()),
        Some((place, problem)) => {
            let more = match faults.len() {
                1 => String::new(),
                count => format!(" (and {} more faults)", count - 1),
            };
            let problem = format!("{}{more}", problem.to_lowercase());
            Err(SceneError::invalid(path, place.clone(), problem, remedy))
        }
    }
}

fn load_buffers(path: &Path, root: &Root, mut blob: Blob<'_>) -> Result<Vec<Vec<u8>>, SceneError> {
    let mut buffers = Vec::new();
    for (index, buffer) in root.buffers.iter().enumerate() {
        let place = format!("buffers[{index}]");
        let remedy = "the file is cut short or a part of it is missing; export the model again";
        let data = match &buffer.uri {
            Some(uri) => load_uri(path, &place, uri)?,
            None => match blob.take() {
                Some(blob) => blob.into_owned(),
                None => return Err(SceneError::invalid(path, place, "it has no data", remedy)),
            },
        };
        if (data.len() as u64) < buffer.byte_length.0 {
            let problem = format!("it has {} of {} bytes", data.len(), buffer.byte_length.0);
            return Err(SceneError::invalid(path, place, problem, remedy));
        }
        buffers.push(data);
    }
    Ok(buffers)
}

fn load_uri(path: &Path, place: &str, uri: &str) -> Result<Vec<u8>, SceneError> {
    let invalid =
        |problem: String| SceneError::invalid(path, place, problem, "name a file beside the model");
    if uri.starts_with("data:") {
        let data = gltf::buffer::Data::from_source(gltf::buffer::Source::Uri(uri), None);
        return data
            .map(|data| data.0)
            .map_err(|error| invalid(format!("bad data URI: {error}")));
    }
    if uri.contains("://") {
        return Err(invalid(format!("`{uri}` is not a relative path")));
    }
    let relative = decode_percent(uri)
        .ok_or_else(|| invalid(format!("`{uri}` is no percent-encoded UTF-8")))?;
    read(&path.parent().unwrap_or(Path::new("")).join(relative))
}

fn decode_percent(uri: &str) -> Option<PathBuf> {
    let mut bytes = Vec::new();
    let mut rest = uri.as_bytes();
    while let Some((&first, tail)) = rest.split_first() {
        rest = tail;
        bytes.push(match (first, tail) {
            (b'%', [high, low, tail @ ..]) => {
                rest = tail;
                let digit = |d: &u8| char::from(*d).to_digit(16);
                u8::try_from(16 * digit(high)? + digit(low)?).ok()?
            }
            (b'%', _) => return None,
            _ => first,
        });
    }
    String::from_utf8(bytes).ok().map(PathBuf::from)
}

/// A mesh's primitives, each with its material.
type Primitives = Vec<(Arc<Mesh>, Arc<Material>)>;

struct Reader<'a> {
    path: &'a Path,
    root: &'a Root,
    buffers: Buffers<'a>,
}

impl Reader<'_> {
    fn invalid(&self, place: String, problem: impl Into<String>) -> SceneError {
        SceneError::invalid(
            self.path,
            place,
            problem,
            "mend the model and export it again",
        )
    }

    fn image(&self, index: usize) -> Result<Arc<Image>, SceneError> {
        let place = format!("images[{index}]");
        let image = &self.root.images[index];
        let decoded = match (&image.uri, image.buffer_view) {
            (Some(uri), _) => Image::decode(&load_uri(self.path, &place, uri)?, self.path, &place),
            (None, Some(view)) => Image::decode(self.buffers.view(view)?.0, self.path, &place),
            (None, None) => Err(self.invalid(place, "it has neither a file nor a buffer view")),
        };
        decoded.map(Arc::new)
    }

    /// The file's materials, and after them the one of primitives that have none; each with the set
    /// of texture coordinates that its texture uses.
    fn materials(&self, images: &[Arc<Image>]) -> Result<Vec<(Arc<Material>, u32)>, SceneError> {
        let mut materials = Vec::new();
        for (index, material) in self.root.materials.iter().enumerate() {
            let pbr = &material.pbr_metallic_roughness;
            let texture = pbr.base_color_texture.as_ref();
            let material = Material {
                base_color: Vec4::from_array(pbr.base_color_factor.0),
                base_color_texture: texture
                    .and_then(|info| self.root.get(info.index))
                    .and_then(|texture| self.texture(texture, images)),
                metallic: pbr.metallic_factor.0,
                roughness: pbr.roughness_factor.0,
                alpha_cutoff: match material.alpha_mode {
                    Checked::Valid(AlphaMode::Mask) => {
                        Some(material.alpha_cutoff.unwrap_or_default().0)
                    }
                    // Exporters write it for surfaces that are opaque all the same.
                    Checked::Valid(AlphaMode::Blend)
                        if texture.is_some() || pbr.base_color_factor.0[3] < 1.0 =>
                    {
                        Some(0.5)
                    }
                    _ => None,
                },
                ..Material::plain("ggx")
            };
            material
                .check()
                .map_err(|problem| self.invalid(format!("materials[{index}]"), problem))?;
            materials.push((Arc::new(material), texture.map_or(0, |info| info.tex_coord)));
        }
        let plain = Material {
            metallic: 1.0,
            ..Material::plain("ggx")
        };
        materials.push((Arc::new(plain), 0));
        Ok(materials)
    }

    fn texture(&self, texture: &json::Texture, images: &[Arc<Image>]) -> Option<Texture> {
        let sampler = texture.sampler.and_then(|sampler| self.root.get(sampler));
        let wrap = |mode: Checked<WrappingMode>| match mode {
            Checked::Valid(WrappingMode::ClampToEdge) => Wrap::Clamp,
            Checked::Valid(WrappingMode::MirroredRepeat) => Wrap::Mirror,
            _ => Wrap::Repeat,
        };
        let nearest = Some(Checked::Valid(MagFilter::Nearest));
        Some(Texture {
            image: Arc::clone(images.get(texture.source.value())?),
            wrap: sampler.map_or([Wrap::Repeat; 2], |s| [wrap(s.wrap_s), wrap(s.wrap_t)]),
            smooth: sampler.is_none_or(|s| s.mag_filter != nearest),
        })
    }

    fn mesh(
        &self,
        index: Index<json::Mesh>,
        materials: &[(Arc<Material>, u32)],
    ) -> Result<Primitives, SceneError> {
        let mut primitives = Vec::new();
        let mesh = self.root.get(index);
        for (number, primitive) in mesh.into_iter().flat_map(|m| &m.primitives).enumerate() {
            let material = primitive
                .material
                .map_or(materials.len() - 1, |m| m.value());
            let Some((material, set)) = materials.get(material) else {
                continue;
            };
            let place = format!("meshes[{index}].primitives[{number}]");
            let mesh = self.primitive(primitive, *set, &place)?;
            if !mesh.indices.is_empty() {
                primitives.push((Arc::new(mesh), Arc::clone(material)));
            }
        }
        Ok(primitives)
    }

    fn primitive(&self, primitive: &Primitive, set: u32, place: &str) -> Result<Mesh, SceneError> {
        let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).copied();
        let Some(positions) = attribute(Semantic::Positions) else {
            return Err(self.invalid(place.to_owned(), "it has no positions"));
        };
        let positions = self.buffers.vectors(positions)?;
        let positions = positions.into_iter().map(Vec3::from_array).collect();
        let mut mesh = Mesh {
            positions,
            ..Mesh::default()
        };
        let count = mesh.positions.len();
        if u32::try_from(count).is_err() {
            return Err(self.invalid(place.to_owned(), format!("{count} vertices are too many")));
        }
        let matching = |what: &str, found: usize| {
            let problem = format!("it has {found} {what} for {count} positions");
            if found == count {
                Ok(())
            } else {
                Err(self.invalid(place.to_owned(), problem))
            }
        };
        mesh.uvs = match attribute(Semantic::TexCoords(set)) {
            Some(uvs) => self
                .buffers
                .vectors(uvs)?
                .into_iter()
                .map(Vec2::from_array)
                .collect(),
            None => vec![Vec2::ZERO; count],
        };
        matching("texture coordinates", mesh.uvs.len())?;
        let corners = match primitive.indices {
            Some(indices) => self.buffers.indices(indices, count)?,
            None => (0..count as u32).collect(),
        };
        mesh.indices = triangles(primitive.mode, &corners);
        let Some(normals) = attribute(Semantic::Normals) else {
            return Ok(mesh.into_flat());
        };
        mesh.normals = self
            .buffers
            .vectors(normals)?
            .into_iter()
            .map(Vec3::from_array)
            .collect();
        matching("normals", mesh.normals.len())?;
        Ok(mesh)
    }

    /// The nodes of the scene, each with its place in it.
    fn nodes(&self) -> Result<Vec<(usize, DAffine3)>, SceneError> {
        let root = self.root;
        let scene = root.scene.map_or(0, |scene| scene.value());
        let roots: Vec<usize> = match root.scenes.get(scene) {
            Some(scene) => scene.nodes.iter().map(Index::value).collect(),
            None => {
                let children = root.nodes.iter().flat_map(|n| n.children.iter().flatten());
                let children: BTreeSet<_> = children.map(Index::value).collect();
                (0..root.nodes.len())
                    .filter(|node| !children.contains(node))
                    .collect()
            }
        };
        let mut found = Vec::new();
        let mut seen = BTreeSet::new();
        // Last in, first out: pushed backwards, nodes come in the file's order.
        let mut stack: Vec<_> = roots
            .into_iter()
            .rev()
            .map(|n| (n, DAffine3::IDENTITY))
            .collect();
        while let Some((index, parent)) = stack.pop() {
            let place = format!("nodes[{index}]");
            if !seen.insert(index) {
                let problem = "it is below itself, or below two nodes: nodes must form a tree";
                return Err(self.invalid(place, problem));
            }
            let Some(node) = root.nodes.get(index) else {
                continue;
            };
            let transform = parent * local(node);
            if !transform.is_finite() {
                return Err(self.invalid(place, "its transform is not finite"));
            }
            found.push((index, transform));
            let children = node.children.iter().flatten().rev();
            stack.extend(children.map(|child| (child.value(), transform)));
        }
        if found.is_empty() {
            return Err(self.invalid("nodes".to_owned(), "the scene has no nodes"));
        }
        Ok(found)
    }
}

fn local(node: &Node) -> DAffine3 {
    if let Some(matrix) = node.matrix {
        return DAffine3::from_mat4(DMat4::from_cols_array(&matrix.map(f64::from)));
    }
    let vector = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
    let rotation = node.rotation.unwrap_or_default().0.map(f64::from);
    DAffine3::from_scale_rotation_translation(
        vector(node.scale.unwrap_or([1.0; 3])),
        DQuat::from_array(rotation).normalize(),
        vector(node.translation.unwrap_or_default()),
    )
}

/// Three corners a triangle; none where points or lines are meant.
fn triangles(mode: Checked<Mode>, corners: &[u32]) -> Vec<u32> {
    match mode {
        Checked::Valid(Mode::Triangles) => corners.chunks_exact(3).flatten().copied().collect(),
        Checked::Valid(Mode::TriangleStrip) => corners
            .windows(3)
            .enumerate()
            // Every other triangle of a strip turns the other way.
            .flat_map(|(i, w)| {
                if i % 2 == 0 {
                    [w[0], w[1], w[2]]
                } else {
                    [w[1], w[0], w[2]]
                }
            })
            .collect(),
        Checked::Valid(Mode::TriangleFan) => match corners {
            [hub, rim @ ..] => rim.windows(2).flat_map(|w| [*hub, w[0], w[1]]).collect(),
            [] => Vec::new(),
        },
        _ => Vec::new(),
    }
}

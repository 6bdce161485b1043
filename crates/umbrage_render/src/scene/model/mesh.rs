//! Meshes: triangles as a file lists them, in the pose that it stores.

use std::{
    collections::{BTreeMap, btree_map::Entry},
    sync::Arc,
};

use glam::{DAffine3, DMat3, DVec3, Vec2, Vec3, Vec4};
use serde::Deserialize;

use super::{
    Reader, SceneError,
    document::Whole,
    material::{Looks, Uvs},
};
use crate::{
    normals::normal_matrix,
    scene::{Material, Mesh},
};

#[derive(Deserialize)]
struct MeshFile {
    #[serde(default)]
    primitives: Vec<Primitive>,
    weights: Option<Vec<f64>>,
    name: Option<String>,
}

#[derive(Deserialize)]
struct Primitive {
    #[serde(default)]
    attributes: Attributes,
    indices: Option<Whole>,
    material: Option<Whole>,
    mode: Option<Whole>,
    #[serde(default)]
    targets: Vec<Attributes>,
}

type Attributes = BTreeMap<String, Whole>;

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct SkinFile {
    joints: Vec<Whole>,
    inverse_bind_matrices: Option<Whole>,
}

/// Everything that decides the shape of a mesh: its number, its morph targets' weights, and the skin that moves it.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Pose {
    mesh: Whole,
    /// The weights' bits.
    weights: Vec<u64>,
    skin: Option<Whole>,
}

/// A mesh's primitive, with its material and where it stands.
#[derive(Clone)]
pub(super) struct Shape {
    pub(super) mesh: Arc<Mesh>,
    pub(super) material: Arc<Material>,
    /// Mesh to scene, of a mesh that a skin moves; others stand where their nodes do.
    pub(super) placed: Option<DAffine3>,
}

/// Meshes read so far.
#[derive(Default)]
pub(super) struct Shapes {
    looks: Looks,
    shapes: BTreeMap<Pose, (Option<String>, Vec<Shape>)>,
}

impl Shapes {
    /// The name of the mesh `mesh` in the pose that its node asks for, and its primitives.
    pub(super) fn posed(
        &mut self,
        reader: &Reader<'_>,
        (mesh, weights, skin): (Whole, Option<&[f64]>, Option<Whole>),
        by: &str,
    ) -> Result<&(Option<String>, Vec<Shape>), SceneError> {
        let bits = weights.into_iter().flatten().map(|weight| weight.to_bits());
        let pose = Pose {
            mesh,
            weights: bits.collect(),
            skin,
        };
        Ok(match self.shapes.entry(pose) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(vacant) => {
                let posing = (mesh, weights, skin);
                vacant.insert(reader.shapes(&mut self.looks, posing, by)?)
            }
        })
    }
}

impl Reader<'_> {
    fn shapes(
        &self,
        looks: &mut Looks,
        (index, weights, skin): (Whole, Option<&[f64]>, Option<Whole>),
        by: &str,
    ) -> Result<(Option<String>, Vec<Shape>), SceneError> {
        let file: MeshFile = self.document.element("meshes", index, by)?;
        let weights = weights.or(file.weights.as_deref()).unwrap_or_default();
        let skin = skin.map(|skin| self.skin(skin, by)).transpose()?;
        let mut shapes = Vec::new();
        for (number, primitive) in file.primitives.iter().enumerate() {
            let place = format!("meshes[{}].primitives[{number}]", index.0);
            let mode = primitive.mode.map_or(TRIANGLES, |mode| mode.0);
            if mode > FAN {
                let problem = format!("its mode {mode} is none of glTF's");
                return Err(self.document.invalid(&place, problem));
            }
            // Primitives that are not drawn are noted with the file's other left-out features.
            if mode < TRIANGLES || !primitive.attributes.contains_key("POSITION") {
                continue;
            }
            let look = self.look(looks, primitive.material, &place)?;
            let (mesh, placed) =
                self.primitive(primitive, look.uvs, (weights, skin.as_deref()), &place)?;
            if !mesh.indices.is_empty() {
                shapes.push(Shape {
                    material: self.material(&look, &mesh.colors),
                    mesh: Arc::new(mesh),
                    placed,
                });
            }
        }
        Ok((file.name, shapes))
    }

    /// Transform of each joint's vertices, from the mesh to the scene.
    fn skin(&self, index: Whole, by: &str) -> Result<Vec<DAffine3>, SceneError> {
        let skin: SkinFile = self.document.element("skins", index, by)?;
        let place = format!("skins[{}]", index.0);
        let inverses = match skin.inverse_bind_matrices {
            Some(matrices) => self.document.floats::<16>(matrices, &place)?,
            None => Vec::new(),
        };
        if skin.inverse_bind_matrices.is_some() && inverses.len() < skin.joints.len() {
            let (found, joints) = (inverses.len(), skin.joints.len());
            let problem = format!("it has {found} inverse bind matrices for {joints} joints");
            return Err(self.document.invalid(&place, problem));
        }
        let mut inverses = inverses.iter().map(|matrix| {
            let matrix = glam::DMat4::from_cols_array(&matrix.map(f64::from));
            DAffine3::from_mat4(matrix)
        });
        let joints = skin.joints.iter().map(|joint| {
            let inverse = inverses.next().unwrap_or(DAffine3::IDENTITY);
            Ok(self.world(*joint, &place)? * inverse)
        });
        joints.collect()
    }

    fn primitive(
        &self,
        primitive: &Primitive,
        uvs: Uvs,
        (weights, skin): (&[f64], Option<&[DAffine3]>),
        place: &str,
    ) -> Result<(Mesh, Option<DAffine3>), SceneError> {
        let vertices = Vertices {
            reader: self,
            primitive,
            weights,
            place,
        };
        let positions = vertices.read::<3>("POSITION", None)?.unwrap_or_default();
        let count = positions.len();
        if u32::try_from(count).is_err() {
            let problem = format!("{count} vertices are too many");
            return Err(self.document.invalid(place, problem));
        }
        let normals = vertices.read::<3>("NORMAL", Some(count))?;
        let normals = normals.map(|normals| {
            let unit = |normal: [f32; 3]| DVec3::from(normal.map(f64::from)).normalize_or_zero();
            normals
                .into_iter()
                .map(|normal| unit(normal).as_vec3())
                .collect()
        });
        let corners = match primitive.indices {
            Some(indices) => self.document.indices(indices, place, count)?,
            None => (0..count as u32).collect(),
        };
        let mut mesh = Mesh {
            positions: positions.into_iter().map(Vec3::from_array).collect(),
            normals: normals.unwrap_or_default(),
            uvs: vertices.uvs(uvs, count)?,
            colors: vertices.colors(count)?,
            indices: triangles(primitive.mode.map_or(TRIANGLES, |mode| mode.0), &corners),
        };
        let placed = match skin {
            Some(joints) => Some(vertices.bend(&mut mesh, joints)?),
            None => None,
        };
        if !mesh.positions.iter().all(|position| position.is_finite()) {
            let problem = "its pose takes a vertex to where nothing is finite";
            return Err(self.document.invalid(place, problem));
        }
        match mesh.normals.is_empty() {
            true => Ok((mesh.into_flat(), placed)),
            false => Ok((mesh.into_used(), placed)),
        }
    }
}

/// A primitive's vertices, and how far each of its morph targets is taken.
struct Vertices<'a, 'd> {
    reader: &'a Reader<'d>,
    primitive: &'a Primitive,
    weights: &'a [f64],
    place: &'a str,
}

impl Vertices<'_, '_> {
    fn invalid(&self, problem: impl Into<String>) -> SceneError {
        self.reader.document.invalid(self.place, problem)
    }

    /// An attribute with its morph targets, one vector for each of `count` vertices; none where the primitive has
    /// none.
    fn read<const N: usize>(
        &self,
        name: &str,
        count: Option<usize>,
    ) -> Result<Option<Vec<[f32; N]>>, SceneError> {
        let document = self.reader.document;
        let Some(accessor) = self.primitive.attributes.get(name) else {
            return Ok(None);
        };
        let vectors = document.floats::<N>(*accessor, self.place)?;
        let count = count.unwrap_or(vectors.len());
        self.check_count(name, vectors.len(), count)?;
        let taken = self.primitive.targets.iter().zip(self.weights);
        let mut morphed: Option<Vec<[f64; N]>> = None;
        for (target, weight) in taken.filter(|(_, weight)| **weight != 0.0) {
            let Some(accessor) = target.get(name) else {
                continue;
            };
            let offsets = document.floats::<N>(*accessor, self.place)?;
            self.check_count(name, offsets.len(), count)?;
            let sums = morphed.get_or_insert_with(|| {
                vectors.iter().map(|vector| vector.map(f64::from)).collect()
            });
            for (sum, offset) in sums.iter_mut().zip(offsets) {
                for (sum, offset) in sum.iter_mut().zip(offset) {
                    *sum += weight * f64::from(offset);
                }
            }
        }
        Ok(Some(match morphed {
            Some(sums) => sums.into_iter().map(|sum| sum.map(|x| x as f32)).collect(),
            None => vectors,
        }))
    }

    fn check_count(&self, name: &str, found: usize, count: usize) -> Result<(), SceneError> {
        match found == count {
            true => Ok(()),
            false => Err(self.invalid(format!("it has {found} of {name} for {count} positions"))),
        }
    }

    /// Texture coordinates of `count` vertices; zeros where no texture is looked up.
    fn uvs(&self, uvs: Uvs, count: usize) -> Result<Vec<Vec2>, SceneError> {
        let none = || vec![Vec2::ZERO; count];
        let Some(set) = uvs.set.or(self.reader.textured.then_some(0)) else {
            return Ok(none());
        };
        let name = format!("TEXCOORD_{set}");
        let Some(found) = self.read::<2>(&name, Some(count))? else {
            if uvs.set.is_some() {
                let instead = "the texture's first texel is everywhere";
                let feature = format!("a missing {name}");
                self.reader.notes.tell(&feature, instead, self.place);
            }
            return Ok(none().into_iter().map(|uv| uvs.apply(uv)).collect());
        };
        let found = found.into_iter().map(|uv| uvs.apply(Vec2::from_array(uv)));
        let found: Vec<_> = found.collect();
        match found.iter().all(|uv| uv.is_finite()) {
            true => Ok(found),
            false => Err(self.invalid(format!("its {name} is taken to where nothing is finite"))),
        }
    }

    /// The vertices' colours; none where there are none, or all are white.
    fn colors(&self, count: usize) -> Result<Vec<Vec4>, SceneError> {
        const NAME: &str = "COLOR_0";
        let Some(accessor) = self.primitive.attributes.get(NAME) else {
            return Ok(Vec::new());
        };
        let colors: Vec<Vec4> = match self.reader.document.width(*accessor, self.place)? {
            3 => {
                let colors = self.read::<3>(NAME, Some(count))?.unwrap_or_default();
                colors
                    .into_iter()
                    .map(|color| Vec3::from(color).extend(1.0))
                    .collect()
            }
            _ => {
                let colors = self.read::<4>(NAME, Some(count))?.unwrap_or_default();
                colors.into_iter().map(Vec4::from_array).collect()
            }
        };
        let clamped = colors
            .into_iter()
            .map(|color| color.clamp(Vec4::ZERO, Vec4::ONE));
        let colors: Vec<_> = clamped.collect();
        match colors.iter().all(|color| *color == Vec4::ONE) {
            true => Ok(Vec::new()),
            false => Ok(colors),
        }
    }

    /// Bends the mesh to where `joints` hold its vertices, and returns the transform that it then has: from the mesh
    /// to the scene.
    fn bend(&self, mesh: &mut Mesh, joints: &[DAffine3]) -> Result<DAffine3, SceneError> {
        let holds = self.holds(mesh.positions.len(), joints)?;
        let place =
            |(position, hold): (&Vec3, &DAffine3)| hold.transform_point3(position.as_dvec3());
        let places: Vec<DVec3> = mesh.positions.iter().zip(&holds).map(place).collect();
        let least = places.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let most = places.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
        // Near its own origin an f32 tells its vertices apart, wherever it stands.
        let middle = 0.5 * (least + most);
        if !middle.is_finite() {
            return Err(self.invalid("its skin takes it to where nothing is finite"));
        }
        for (position, place) in mesh.positions.iter_mut().zip(places) {
            *position = (place - middle).as_vec3();
        }
        for (normal, hold) in mesh.normals.iter_mut().zip(&holds) {
            let turned = normal_matrix(hold.matrix3) * normal.as_dvec3();
            *normal = turned.normalize_or_zero().as_vec3();
        }
        // A mirror turns a triangle round.
        for corners in mesh.indices.as_chunks_mut::<3>().0 {
            let hold = holds.get(corners[0] as usize);
            if hold.is_some_and(|hold| hold.matrix3.determinant() < 0.0) {
                corners.swap(1, 2);
            }
        }
        Ok(DAffine3::from_translation(middle))
    }

    /// Transform of each vertex: the mean of its joints' by their weights, or its first joint's without any weight.
    fn holds(&self, count: usize, joints: &[DAffine3]) -> Result<Vec<DAffine3>, SceneError> {
        let zero = DAffine3::from_mat3_translation(DMat3::ZERO, DVec3::ZERO);
        let mut holds = vec![(zero, 0.0_f64, None); count];
        for set in 0_u32.. {
            let (numbers, weights) = (format!("JOINTS_{set}"), format!("WEIGHTS_{set}"));
            let Some(numbers) = self.primitive.attributes.get(&numbers) else {
                break;
            };
            let numbers = self.reader.document.wholes::<4>(*numbers, self.place)?;
            self.check_count("joints", numbers.len(), count)?;
            let weights = self.read::<4>(&weights, Some(count))?;
            let weights =
                weights.ok_or_else(|| self.invalid(format!("it has no WEIGHTS_{set}")))?;
            for ((hold, sum, first), (numbers, weights)) in
                holds.iter_mut().zip(numbers.into_iter().zip(weights))
            {
                for (number, weight) in numbers.into_iter().zip(weights) {
                    let weight = f64::from(weight);
                    let joint = joints.get(number as usize);
                    if first.is_none() {
                        *first = joint.copied();
                    }
                    if weight == 0.0 {
                        continue;
                    }
                    let Some(joint) = joint.filter(|_| weight > 0.0) else {
                        let problem = format!(
                            "joint {number} of {} holds a vertex with the weight {weight}",
                            joints.len()
                        );
                        return Err(self.invalid(problem));
                    };
                    hold.matrix3 += joint.matrix3 * weight;
                    hold.translation += joint.translation * weight;
                    *sum += weight;
                }
            }
        }
        if !self.primitive.attributes.contains_key("JOINTS_0") {
            return Err(self.invalid("a skin moves it, but it has no JOINTS_0"));
        }
        let mean = |(hold, sum, first): (DAffine3, f64, Option<DAffine3>)| match sum > 0.0 {
            true => DAffine3 {
                matrix3: hold.matrix3 * sum.recip(),
                translation: hold.translation * sum.recip(),
            },
            false => first.unwrap_or(DAffine3::IDENTITY),
        };
        Ok(holds.into_iter().map(mean).collect())
    }
}

const TRIANGLES: u64 = 4;
const STRIP: u64 = 5;
const FAN: u64 = 6;

/// Three corners a triangle.
fn triangles(mode: u64, corners: &[u32]) -> Vec<u32> {
    match mode {
        STRIP => corners
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
        FAN => match corners {
            [hub, rim @ ..] => rim.windows(2).flat_map(|w| [*hub, w[0], w[1]]).collect(),
            [] => Vec::new(),
        },
        _ => corners.as_chunks::<3>().0.as_flattened().to_vec(),
    }
}

//! Scenes: what is to be rendered, as plain data in f64.

mod bare;
mod closed;
mod error;
mod file;
mod file_lights;
mod image;
mod left_out;
mod medium;
mod model;
mod own_lights;
mod shapes;

use std::{path::Path, sync::Arc};

use glam::{DAffine3, DQuat, DVec3, Vec2, Vec3, Vec4};
use umbrage_shadow::{Aabb, Field, Light, Projection, View, overlap, plain_number};
use umbrage_wgpu::Shadow;

pub(crate) use self::image::encode_srgb;
pub use self::{
    error::SceneError,
    image::{Image, Level},
    left_out::LeftOut,
    medium::Medium,
};

/// A scene to be rendered. World space: metres, right-handed, y up.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Objects to see, in the order of the file.
    pub objects: Vec<Object>,
    /// Lights of the scene.
    pub lights: Vec<SceneLight>,
    /// The camera.
    pub camera: Camera,
    /// Light from everywhere, as the radiance of a white surface in it; linear RGB.
    pub ambient: Vec3,
    /// Colour seen where there is nothing, linear RGB.
    pub background: Vec3,
    /// Properties of the air; none for air that nothing is seen of.
    pub medium: Option<Medium>,
    /// Features of the models' files that are not shown, each once.
    pub left_out: Vec<LeftOut>,
}

/// A mesh in its place.
#[derive(Clone, Debug)]
pub struct Object {
    /// Name in reports.
    pub name: String,
    /// Its shape; objects that share it are drawn as instances.
    pub mesh: Arc<Mesh>,
    /// Its material.
    pub material: Arc<Material>,
    /// Object to world.
    pub transform: DAffine3,
    /// The box around it in the world.
    pub bounds: Aabb,
}

/// Triangles, with one normal and one texture coordinate a vertex.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Metres, object space.
    pub positions: Vec<Vec3>,
    /// Object space; unit, or zero where a triangle has no area.
    pub normals: Vec<Vec3>,
    /// Texture coordinates, v down; zeros where the file has none.
    pub uvs: Vec<Vec2>,
    /// Linear RGB and opacity of vertices, from 0 to 1, that multiply the material's; none where all would be white.
    pub colors: Vec<Vec4>,
    /// Three vertices a triangle, counter-clockwise seen from the front.
    pub indices: Vec<u32>,
}

/// How an object looks, and whether it casts.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// The value of the shader library's axis `surface`.
    pub surface: String,
    /// Linear RGB and opacity; multiplies the texture.
    pub base_color: Vec4,
    /// The colour's texture.
    pub base_color_texture: Option<Texture>,
    /// 0 dielectric to 1 metal.
    pub metallic: f32,
    /// 0 smooth to 1 rough.
    pub roughness: f32,
    /// Opacity below which there is no surface; none for a surface without holes.
    pub alpha_cutoff: Option<f32>,
    /// Whether it casts shadows.
    pub casts: bool,
}

/// A picture on a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// The picture.
    pub image: Arc<Image>,
    /// How the picture goes on beside its edges, across and down.
    pub wrap: [Wrap; 2],
    /// Whether texels are blended rather than shown as squares.
    pub smooth: bool,
}

/// How a texture goes on beside its edges.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Wrap {
    /// The texture again.
    Repeat,
    /// The texture again, every other time mirrored.
    Mirror,
    /// Its edge.
    Clamp,
}

/// A light, what it is projected through, and how it casts shadows.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneLight {
    /// Name in reports.
    pub name: String,
    /// The light.
    pub light: Light,
    /// Picture that a spot light shines through; its top is up where the light shines level.
    pub cookie: Option<Arc<Image>>,
    /// How it casts shadows; none casts none.
    pub shadow: Option<Shadow>,
}

/// The ground and sun made up for a model that comes without a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Staging {
    /// A ground under it.
    pub ground: bool,
    /// A sun.
    pub sun: bool,
}

impl Default for Staging {
    fn default() -> Self {
        Self {
            ground: true,
            sun: true,
        }
    }
}

/// Where the picture is taken from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// World space, metres.
    pub position: DVec3,
    /// From its axes to the world's; it looks along −z of its own.
    pub rotation: DQuat,
    /// Field of view.
    pub field: Field,
    /// The nearest view depth that is seen, from the position along the view's direction; metres. Above 0, except for
    /// an orthographic camera, which sees behind its position as well.
    pub near: f64,
    /// The farthest that is seen; metres.
    pub far: f64,
}

impl Camera {
    /// The camera as a view of a picture of the given size in pixels (both above 0). For the view that a renderer plans
    /// with, see [`Scene::view`].
    pub fn view(&self, width: u32, height: u32) -> View {
        let view = View {
            position: self.position,
            rotation: self.rotation,
            projection: Projection {
                field: self.field,
                aspect: f64::from(width) / f64::from(height),
                near: self.near,
                far: self.far,
            },
            eye: 0.0,
        };
        view.around(self.near, self.far)
    }
}

impl Scene {
    /// The camera's view, from which a picture of the given size in pixels (both above 0) is rendered. Positions on the
    /// device and in plans are relative to the view's position, which is the camera's own unless that is orthographic:
    /// then it [stands](View::around) before the objects that are seen. In a medium, all from plane to plane is seen.
    pub fn view(&self, width: u32, height: u32) -> View {
        let view = self.camera.view(width, height);
        if !view.projection.is_orthographic() || self.medium.is_some() {
            return view;
        }
        let (frustum, forward) = (view.frustum_relative(), view.forward());
        let boxes = self.objects.iter().map(|object| object.bounds);
        let boxes = boxes.filter(Aabb::is_finite);
        let seen = boxes.flat_map(|aabb| overlap(&aabb.translate(-view.position), &[&frustum]));
        let depths = seen.map(|point| point.dot(forward));
        let range = depths
            .map(|depth| [depth; 2])
            .reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]);
        match range {
            Some([nearest, farthest]) => view.around(nearest, farthest),
            None => view,
        }
    }

    /// Whether `light`, one of the scene's, casts shadows: if it has a `shadow` whose method is not `none`. A scene in which
    /// no light has a `shadow` leaves it open: there all cast as soon as a method is brought to them
    /// ([`RenderOptions::shadow`](crate::RenderOptions::shadow), a comparison), and in the truth. The shadow term of a light
    /// that casts none is 1.
    pub fn casts_shadow(&self, light: &SceneLight) -> bool {
        match &light.shadow {
            Some(shadow) => shadow.method != Shadow::NONE,
            None => self.lights.iter().all(|light| light.shadow.is_none()),
        }
    }

    /// Removes all lights but the one at this place; nothing else changes, and it casts shadows if it did. None where
    /// there is no such light.
    pub fn lit_by(mut self, light: usize) -> Option<Self> {
        let kept = self.lights.get(light)?;
        let casts = self.casts_shadow(kept);
        let mut kept = kept.clone();
        if !casts {
            kept.shadow = Some(Shadow {
                method: Shadow::NONE.to_owned(),
                ..Shadow::default()
            });
        }
        self.lights = vec![kept];
        Some(self)
    }

    /// Loads a scene file (`.ron`) or a model (`.gltf`, `.glb`), which gets a ground, and where it has
    /// none a camera and a sun that fit it.
    ///
    /// # Errors
    /// A file that is missing, damaged, or says what cannot be rendered.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, SceneError> {
        Self::load_with(path, Staging::default())
    }

    /// The same, of a model with no more made up than `staging` says.
    ///
    /// # Errors
    /// Beside those of [`load`](Self::load), a scene file of which something is not to be made up: nothing is.
    pub fn load_with(path: impl AsRef<Path>, staging: Staging) -> Result<Self, SceneError> {
        let path = path.as_ref();
        let extension = path
            .extension()
            .and_then(|e| e.to_str())
            .unwrap_or_default();
        match extension.to_ascii_lowercase().as_str() {
            "ron" if staging != Staging::default() => Err(SceneError::invalid(
                path,
                "scene",
                "a scene file has no ground and no sun but its own, which cannot be left out",
                "take them out of the file, or name a bare model",
            )),
            "ron" => file::load(path),
            "gltf" | "glb" => bare::load(path, staging),
            _ => Err(SceneError::Unknown {
                path: path.to_owned(),
            }),
        }
    }
}

impl Mesh {
    /// The box around the mesh placed by `transform`; of a mesh without vertices, an empty box.
    pub fn bounds(&self, transform: &DAffine3) -> Aabb {
        let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for position in &self.positions {
            let position = transform.transform_point3(position.as_dvec3());
            (min, max) = (min.min(position), max.max(position));
        }
        Aabb { min, max }
    }

    /// The mesh with three vertices of its own for each triangle, and the triangles' own normals.
    fn into_flat(self) -> Self {
        let mut flat = Self::default();
        for triangle in self.indices.chunks_exact(3) {
            // Indices were checked when the file was read.
            let corners = [0, 1, 2].map(|corner| triangle[corner] as usize);
            let [a, b, c] = corners.map(|corner| self.positions[corner]);
            // In f64: the cross product of a small triangle's edges would underflow.
            let (ab, ac) = ((b - a).as_dvec3(), (c - a).as_dvec3());
            let normal = ab.cross(ac).normalize_or_zero().as_vec3();
            flat.positions.extend([a, b, c]);
            flat.normals.extend([normal; 3]);
            flat.uvs.extend(corners.map(|corner| self.uvs[corner]));
            let colors = corners.map(|corner| self.colors.get(corner).copied());
            flat.colors.extend(colors.into_iter().flatten());
        }
        flat.indices = (0..flat.positions.len() as u32).collect();
        flat
    }
}

impl Mesh {
    /// The mesh without the vertices that no triangle uses: several meshes of a file may share one list.
    fn into_used(self) -> Self {
        let mut places = vec![None; self.positions.len()];
        let mut used = Self::default();
        let mut order = Vec::new();
        for index in &self.indices {
            // Indices were checked when the file was read.
            let place = places[*index as usize].get_or_insert_with(|| {
                order.push(*index as usize);
                order.len() as u32 - 1
            });
            used.indices.push(*place);
        }
        if order.len() == self.positions.len() {
            return self;
        }
        used.positions = order.iter().map(|vertex| self.positions[*vertex]).collect();
        used.normals = order.iter().map(|vertex| self.normals[*vertex]).collect();
        used.uvs = order.iter().map(|vertex| self.uvs[*vertex]).collect();
        let colors = order.iter().filter_map(|vertex| self.colors.get(*vertex));
        used.colors = colors.copied().collect();
        used
    }
}

impl Material {
    /// A plain surface of the given kind: white, rough, casting.
    pub fn plain(surface: impl Into<String>) -> Self {
        Self {
            surface: surface.into(),
            base_color: Vec4::ONE,
            base_color_texture: None,
            metallic: 0.0,
            roughness: 1.0,
            alpha_cutoff: None,
            casts: true,
        }
    }

    /// Says which number lies outside its range, where one does.
    fn check(&self) -> Result<(), String> {
        let color = self
            .base_color
            .to_array()
            .map(|value| ("base_color", value, f32::MAX));
        let rest = [
            ("metallic", self.metallic, 1.0),
            ("roughness", self.roughness, 1.0),
            (
                "alpha_cutoff",
                self.alpha_cutoff.unwrap_or_default(),
                f32::MAX,
            ),
        ];
        for (name, value, most) in color.into_iter().chain(rest) {
            if !(0.0..=most).contains(&value) {
                let range = if most == 1.0 {
                    "from 0 to 1"
                } else {
                    "finite and not negative"
                };
                return Err(format!("`{name}` is {value}, but must be {range}"));
            }
        }
        Ok(())
    }
}

/// Metres from the origin beyond which nothing is placed: f32 must hold the squares of distances.
const FARTHEST: f64 = 1e15;

impl Object {
    /// A mesh in its place.
    fn place(
        name: String,
        mesh: Arc<Mesh>,
        material: Arc<Material>,
        transform: DAffine3,
    ) -> Result<Self, String> {
        let bounds = mesh.bounds(&transform);
        let farthest = bounds.min.abs().max(bounds.max.abs()).max_element();
        if !transform.is_finite() || bounds.min.is_nan() || farthest.is_nan() || farthest > FARTHEST
        {
            return Err(format!(
                "`{name}` is placed farther than {} m from the origin",
                plain_number(FARTHEST)
            ));
        }
        Ok(Self {
            name,
            mesh,
            material,
            transform,
            bounds,
        })
    }
}

#[cfg(test)]
mod tests;

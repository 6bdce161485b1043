//! Scene files: RON, strict, with paths relative to the file.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    sync::Arc,
};

use glam::{DAffine3, DQuat, DVec3, EulerRot, Vec2, Vec3, Vec4};
use serde::Deserialize;
use umbrage_compose::RonFile;
use umbrage_shadow::{Field, look_along, plain_number};

use super::{
    Camera, Image, LeftOut, Material, Medium, Mesh, Object, Scene, SceneError, Texture, Wrap,
    error::read,
    file_lights::LightFile,
    model::{self, Part},
};

/// A scene file. Lengths in metres, angles in degrees, colours linear.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename = "Scene")]
struct SceneFile {
    camera: CameraFile,
    #[serde(default)]
    ambient: (f32, f32, f32),
    #[serde(default)]
    background: (f32, f32, f32),
    medium: Option<Medium>,
    #[serde(default)]
    lights: Vec<LightFile>,
    models: Vec<ModelFile>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename = "Camera")]
struct CameraFile {
    position: (f64, f64, f64),
    target: Option<(f64, f64, f64)>,
    rotation: Option<RotationFile>,
    /// Of a perspective camera, which it is unless it has a height.
    fov_degrees: Option<f64>,
    /// From the picture's lower to its upper edge, metres.
    orthographic_height: Option<f64>,
    #[serde(default = "default_near")]
    near: f64,
    #[serde(default = "default_far")]
    far: f64,
}

fn default_near() -> f64 {
    0.05
}

fn default_far() -> f64 {
    1000.0
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename = "Model")]
struct ModelFile {
    name: Option<String>,
    file: Option<PathBuf>,
    shape: Option<ShapeFile>,
    #[serde(default)]
    translation: (f64, f64, f64),
    rotation: Option<RotationFile>,
    scale: Option<(f64, f64, f64)>,
    #[serde(default = "default_casts")]
    casts: bool,
    surface: Option<String>,
    #[serde(default)]
    material: MaterialFile,
}

fn default_casts() -> bool {
    true
}

#[derive(Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "snake_case", rename = "Rotation")]
enum RotationFile {
    /// About x, then y, then z of the parent's axes.
    Degrees(f64, f64, f64),
    /// x, y, z, w.
    Quaternion(f64, f64, f64, f64),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "snake_case", rename = "Shape")]
enum ShapeFile {
    /// Level, facing up: extent along x and z.
    Plane {
        size: (f32, f32),
        #[serde(default = "one_tile")]
        tiles: (f32, f32),
    },
    /// Upright, facing +z: extent along x and y.
    Quad {
        size: (f32, f32),
        #[serde(default = "one_tile")]
        tiles: (f32, f32),
    },
    Box {
        size: (f32, f32, f32),
    },
    Sphere {
        radius: f32,
        #[serde(default = "default_segments")]
        segments: u32,
    },
}

fn one_tile() -> (f32, f32) {
    (1.0, 1.0)
}

fn default_segments() -> u32 {
    48
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields, rename = "Material")]
struct MaterialFile {
    base_color: Option<(f32, f32, f32)>,
    base_color_texture: Option<PathBuf>,
    metallic: Option<f32>,
    roughness: Option<f32>,
    alpha_cutoff: Option<f32>,
}

/// State that scene files share: where they are, and what they have already read.
pub(super) struct Loader<'a> {
    path: &'a Path,
    /// The text at the path, for the places of faults.
    text: RonFile,
    /// Also by whether they get a texture here.
    models: BTreeMap<(PathBuf, bool), Vec<Part>>,
    left_out: Vec<LeftOut>,
    images: BTreeMap<PathBuf, Arc<Image>>,
    /// Each once, so that models which look alike are drawn as instances.
    meshes: Vec<Arc<Mesh>>,
    materials: Vec<Arc<Material>>,
}

/// Loads the scene file at `path`.
pub(super) fn load(path: &Path) -> Result<Scene, SceneError> {
    let text = RonFile::load(path)?;
    let file: SceneFile = text.parse()?;
    let mut loader = Loader {
        path,
        text,
        models: BTreeMap::new(),
        left_out: Vec::new(),
        images: BTreeMap::new(),
        meshes: Vec::new(),
        materials: Vec::new(),
    };
    let camera = loader.camera(&file.camera)?;
    let ambient = loader.color("ambient", file.ambient)?;
    let background = loader.color("background", file.background)?;
    let medium = file
        .medium
        .map(|medium| loader.medium(medium))
        .transpose()?;
    let mut lights = Vec::new();
    for (index, light) in file.lights.into_iter().enumerate() {
        lights.push(loader.light(light, &format!("lights[{index}]"))?);
    }
    let mut objects = Vec::new();
    for (index, model) in file.models.into_iter().enumerate() {
        objects.extend(loader.model(model, &format!("models[{index}]"))?);
    }
    if objects.is_empty() {
        return Err(loader.invalid(
            "models",
            "there is nothing to see",
            "name a model or a shape",
        ));
    }
    Ok(Scene {
        objects,
        lights,
        camera,
        ambient,
        background,
        medium,
        left_out: loader.left_out,
    })
}

impl Loader<'_> {
    /// A fault of the value at `place`, such as `lights[1].color`.
    pub(super) fn invalid(
        &self,
        place: &str,
        problem: impl Into<String>,
        remedy: &str,
    ) -> SceneError {
        let message = format!("{place}: {}", problem.into());
        let fault = self.text.fault(message, self.text.at(place), &[]);
        umbrage_compose::Error::from(fault.note(remedy)).into()
    }

    /// `value`, where it lies in `range`.
    pub(super) fn number(
        &self,
        place: String,
        value: f64,
        range: std::ops::RangeInclusive<f64>,
    ) -> Result<f64, SceneError> {
        if range.contains(&value) {
            return Ok(value);
        }
        let problem = format!(
            "it is {}, but must lie from {} to {}",
            plain_number(value),
            plain_number(*range.start()),
            plain_number(*range.end())
        );
        Err(self.invalid(&place, problem, "change it in the scene file"))
    }

    pub(super) fn point(
        &self,
        place: String,
        (x, y, z): (f64, f64, f64),
    ) -> Result<DVec3, SceneError> {
        for value in [x, y, z] {
            self.number(place.clone(), value, -super::FARTHEST..=super::FARTHEST)?;
        }
        Ok(DVec3::new(x, y, z))
    }

    pub(super) fn color(
        &self,
        place: &str,
        (r, g, b): (f32, f32, f32),
    ) -> Result<Vec3, SceneError> {
        for value in [r, g, b] {
            self.number(place.to_owned(), f64::from(value), 0.0..=1e30)?;
        }
        Ok(Vec3::new(r, g, b))
    }

    pub(super) fn image(&mut self, place: &str, file: &Path) -> Result<Arc<Image>, SceneError> {
        let path = self.beside(file);
        if let Some(image) = self.images.get(&path) {
            return Ok(Arc::clone(image));
        }
        let image = Arc::new(Image::decode(&read(&path)?, &path, place)?);
        self.images.insert(path, Arc::clone(&image));
        Ok(image)
    }

    fn beside(&self, file: &Path) -> PathBuf {
        self.path.parent().unwrap_or(Path::new("")).join(file)
    }

    fn rotation(&self, place: &str, rotation: RotationFile) -> Result<DQuat, SceneError> {
        let rotation = match rotation {
            RotationFile::Degrees(x, y, z) => DQuat::from_euler(
                EulerRot::XYZEx,
                x.to_radians(),
                y.to_radians(),
                z.to_radians(),
            ),
            RotationFile::Quaternion(x, y, z, w) => DQuat::from_xyzw(x, y, z, w).normalize(),
        };
        if rotation.is_finite() {
            return Ok(rotation);
        }
        let problem = "it is no rotation: an angle is not finite, or the quaternion is zero";
        Err(self.invalid(
            &format!("{place}.rotation"),
            problem,
            "change it in the scene file",
        ))
    }

    fn camera(&self, file: &CameraFile) -> Result<Camera, SceneError> {
        let position = self.point("camera.position".to_owned(), file.position)?;
        let rotation = match (file.target, file.rotation) {
            (Some(target), None) => {
                let target = self.point("camera.target".to_owned(), target)?;
                look_along(target - position).ok_or_else(|| {
                    let problem = "it is where the camera stands";
                    self.invalid(
                        "camera.target",
                        problem,
                        "name a point in front of the camera",
                    )
                })?
            }
            (None, Some(rotation)) => self.rotation("camera", rotation)?,
            _ => {
                let problem = "either a target or a rotation says where the camera looks";
                return Err(self.invalid("camera", problem, "give one of the two"));
            }
        };
        let field = self.field(file)?;
        let nearest = match field {
            Field::Perspective { .. } => 1e-6,
            // An orthographic camera sees behind its position as well as before it.
            Field::Orthographic { .. } => -1e12,
        };
        let near = self.number("camera.near".to_owned(), file.near, nearest..=1e12)?;
        let far = self.number("camera.far".to_owned(), file.far, nearest..=1e12)?;
        if far <= near {
            let problem = format!("it is {far}, but must lie beyond near, {near}");
            return Err(self.invalid("camera.far", problem, "change one of them"));
        }
        Ok(Camera {
            position,
            rotation,
            field,
            near,
            far,
        })
    }

    fn field(&self, file: &CameraFile) -> Result<Field, SceneError> {
        match (file.fov_degrees, file.orthographic_height) {
            (Some(_), Some(_)) => Err(self.invalid(
                "camera",
                "it has both an angle, `fov_degrees`, and an `orthographic_height`",
                "give one of the two",
            )),
            (degrees, None) => {
                let degrees = degrees.unwrap_or(45.0);
                let place = "camera.fov_degrees".to_owned();
                let degrees = self.number(place, degrees, 0.01..=179.0)?;
                Ok(Field::Perspective {
                    fov_y: degrees.to_radians(),
                })
            }
            (None, Some(height)) => {
                let place = "camera.orthographic_height".to_owned();
                let height = self.number(place, height, 1e-6..=1e12)?;
                Ok(Field::Orthographic { height })
            }
        }
    }

    fn model(&mut self, file: ModelFile, place: &str) -> Result<Vec<Object>, SceneError> {
        let parts = match (&file.file, &file.shape) {
            (Some(model), None) => self.parts(model, file.material.base_color_texture.is_some())?,
            (None, Some(shape)) => vec![self.shape(shape, place)?],
            _ => {
                let problem = "a model is either a file or a shape";
                return Err(self.invalid(place, problem, "give one of the two"));
            }
        };
        let translation = self.point(format!("{place}.translation"), file.translation)?;
        let scale = self.point(
            format!("{place}.scale"),
            file.scale.unwrap_or((1.0, 1.0, 1.0)),
        )?;
        let rotation = match file.rotation {
            Some(rotation) => self.rotation(place, rotation)?,
            None => DQuat::IDENTITY,
        };
        let model = DAffine3::from_scale_rotation_translation(scale, rotation, translation);
        let mut objects = Vec::new();
        for part in parts {
            let material = self.material(&part.material, &file, place)?;
            let material = share(&mut self.materials, material);
            let name = file.name.clone().unwrap_or(part.name);
            let object = Object::place(name, part.mesh, material, model * part.transform)
                .map_err(|problem| self.invalid(place, problem, "change its transform"))?;
            objects.push(object);
        }
        Ok(objects)
    }

    /// The parts of a model, which gets a texture here if it is `textured`.
    fn parts(&mut self, file: &Path, textured: bool) -> Result<Vec<Part>, SceneError> {
        let path = self.beside(file);
        let known = (path, textured);
        if let Some(parts) = self.models.get(&known) {
            return Ok(parts.clone());
        }
        let model = model::load(&known.0, textured)?;
        // The scene file's own stand in their place.
        let [lamps, eyes] = [model.lamps.len(), model.eyes.len()];
        let unused = [
            LeftOut::new(
                file,
                "KHR_lights_punctual",
                lamps,
                "the scene file's lights shine",
            ),
            LeftOut::new(file, "cameras", eyes, "the scene file's camera looks"),
        ];
        for left_out in unused.into_iter().flatten().chain(model.left_out) {
            if !self.left_out.contains(&left_out) {
                self.left_out.push(left_out);
            }
        }
        self.models.insert(known, model.parts.clone());
        Ok(model.parts)
    }

    fn shape(&mut self, shape: &ShapeFile, place: &str) -> Result<Part, SceneError> {
        let positive = |name: &str, value: f32| {
            self.number(
                format!("{place}.shape.{name}"),
                f64::from(value),
                1e-6..=1e12,
            )
        };
        type Shape = fn(Vec2, Vec2) -> Mesh;
        let rectangle = |shape: Shape, size: (f32, f32), tiles: (f32, f32)| {
            for (name, value) in [
                ("size", size.0),
                ("size", size.1),
                ("tiles", tiles.0),
                ("tiles", tiles.1),
            ] {
                positive(name, value)?;
            }
            Ok::<Mesh, SceneError>(shape(size.into(), tiles.into()))
        };
        let (name, mesh) = match *shape {
            ShapeFile::Plane { size, tiles } => ("plane", rectangle(Mesh::plane, size, tiles)?),
            ShapeFile::Quad { size, tiles } => ("quad", rectangle(Mesh::quad, size, tiles)?),
            ShapeFile::Box { size } => {
                for value in [size.0, size.1, size.2] {
                    positive("size", value)?;
                }
                ("box", Mesh::cuboid(size.into()))
            }
            ShapeFile::Sphere { radius, segments } => {
                positive("radius", radius)?;
                self.number(
                    format!("{place}.shape.segments"),
                    f64::from(segments),
                    4.0..=1024.0,
                )?;
                ("sphere", Mesh::sphere(radius, segments))
            }
        };
        Ok(Part {
            name: name.to_owned(),
            mesh: share(&mut self.meshes, mesh),
            material: Arc::new(Material::plain("lambert")),
            transform: DAffine3::IDENTITY,
        })
    }

    fn material(
        &mut self,
        base: &Material,
        file: &ModelFile,
        place: &str,
    ) -> Result<Material, SceneError> {
        let mut material = base.clone();
        material.casts = file.casts;
        if let Some(surface) = &file.surface {
            material.surface.clone_from(surface);
        }
        let chosen = &file.material;
        if let Some((r, g, b)) = chosen.base_color {
            material.base_color = Vec4::new(r, g, b, material.base_color.w);
        }
        if let Some(texture) = &chosen.base_color_texture {
            let image = self.image(&format!("{place}.material.base_color_texture"), texture)?;
            material.base_color_texture = Some(Texture {
                image,
                wrap: [Wrap::Repeat; 2],
                smooth: true,
            });
        }
        material.metallic = chosen.metallic.unwrap_or(material.metallic);
        material.roughness = chosen.roughness.unwrap_or(material.roughness);
        material.alpha_cutoff = chosen.alpha_cutoff.or(material.alpha_cutoff);
        material.check().map_err(|problem| {
            self.invalid(
                &format!("{place}.material"),
                problem,
                "change it in the scene file",
            )
        })?;
        Ok(material)
    }
}

/// `value` as one of `known`, which it joins where it is new.
fn share<T: PartialEq>(known: &mut Vec<Arc<T>>, value: T) -> Arc<T> {
    if let Some(same) = known.iter().find(|known| ***known == value) {
        return Arc::clone(same);
    }
    let value = Arc::new(value);
    known.push(Arc::clone(&value));
    value
}

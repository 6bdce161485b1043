//! Materials, and how their textures lie on meshes.

use std::{collections::BTreeMap, sync::Arc};

use glam::{DAffine2, DMat2, DVec2, Vec2, Vec4};
use serde::Deserialize;

use super::{Reader, SceneError, document::Whole};
use crate::scene::{Image, Material, Texture, Wrap};

#[derive(Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
struct MaterialFile {
    pbr_metallic_roughness: Reflection,
    alpha_mode: Option<String>,
    alpha_cutoff: Option<f32>,
}

#[derive(Deserialize)]
#[serde(default, rename_all = "camelCase")]
struct Reflection {
    base_color_factor: [f32; 4],
    base_color_texture: Option<TextureInfo>,
    metallic_factor: f32,
    roughness_factor: f32,
}

impl Default for Reflection {
    fn default() -> Self {
        Self {
            base_color_factor: [1.0; 4],
            base_color_texture: None,
            metallic_factor: 1.0,
            roughness_factor: 1.0,
        }
    }
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct TextureInfo {
    index: Whole,
    #[serde(default)]
    tex_coord: Whole,
    #[serde(default)]
    extensions: TextureInfoExtensions,
}

#[derive(Default, Deserialize)]
struct TextureInfoExtensions {
    #[serde(rename = "KHR_texture_transform")]
    transform: Option<TextureTransform>,
}

#[derive(Deserialize)]
#[serde(default, rename_all = "camelCase")]
struct TextureTransform {
    offset: [f64; 2],
    rotation: f64,
    scale: [f64; 2],
    tex_coord: Option<Whole>,
}

impl Default for TextureTransform {
    fn default() -> Self {
        Self {
            offset: [0.0; 2],
            rotation: 0.0,
            scale: [1.0; 2],
            tex_coord: None,
        }
    }
}

#[derive(Deserialize)]
struct TextureFile {
    source: Option<Whole>,
    sampler: Option<Whole>,
}

#[derive(Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
struct Sampler {
    wrap_s: Option<Whole>,
    wrap_t: Option<Whole>,
    mag_filter: Option<Whole>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct ImageFile {
    uri: Option<String>,
    buffer_view: Option<Whole>,
}

/// A material, and what a mesh must know to be drawn with it.
pub(super) struct Look {
    material: Arc<Material>,
    /// For meshes that are less than opaque themselves, where the blended material is not.
    cut: Option<Arc<Material>>,
    pub(super) uvs: Uvs,
    place: String,
}

/// Where a mesh has its texture coordinates from.
#[derive(Clone, Copy, Default)]
pub(super) struct Uvs {
    /// The set's number; none where no texture reads them.
    pub(super) set: Option<u64>,
    /// From the set's to the texture's.
    transform: Option<DAffine2>,
}

impl Uvs {
    pub(super) fn apply(&self, uv: Vec2) -> Vec2 {
        match &self.transform {
            Some(transform) => transform.transform_point2(uv.as_dvec2()).as_vec2(),
            None => uv,
        }
    }
}

/// Materials read so far.
#[derive(Default)]
pub(super) struct Looks {
    /// By their numbers; none is the key of the default material, for primitives that name no material.
    looks: BTreeMap<Option<Whole>, Arc<Look>>,
    images: BTreeMap<Whole, Arc<Image>>,
}

impl Reader<'_> {
    /// The material of a primitive, which is `by`.
    pub(super) fn look(
        &self,
        looks: &mut Looks,
        index: Option<Whole>,
        by: &str,
    ) -> Result<Arc<Look>, SceneError> {
        if let Some(known) = looks.looks.get(&index) {
            return Ok(Arc::clone(known));
        }
        let look = match index {
            Some(index) => self.read_look(&mut looks.images, index, by)?,
            None => Look {
                material: Arc::new(Material {
                    metallic: 1.0,
                    ..Material::plain("ggx")
                }),
                cut: None,
                uvs: Uvs::default(),
                place: String::new(),
            },
        };
        let look = Arc::new(look);
        looks.looks.insert(index, Arc::clone(&look));
        Ok(look)
    }

    fn read_look(
        &self,
        images: &mut BTreeMap<Whole, Arc<Image>>,
        index: Whole,
        by: &str,
    ) -> Result<Look, SceneError> {
        let file: MaterialFile = self.document.element("materials", index, by)?;
        let place = format!("materials[{}]", index.0);
        let invalid = |problem: String| self.document.invalid(&place, problem);
        let pbr = &file.pbr_metallic_roughness;
        let (mut texture, mut uvs) = (None, Uvs::default());
        if let Some(info) = &pbr.base_color_texture {
            texture = self.texture(images, info.index, &place)?;
            if texture.is_some() {
                uvs = uvs_of(info).map_err(invalid)?;
            }
        }
        let (alpha_cutoff, is_blended) = match file.alpha_mode.as_deref().unwrap_or("OPAQUE") {
            "OPAQUE" => (None, false),
            "MASK" => (Some(file.alpha_cutoff.unwrap_or(0.5)), false),
            "BLEND" => (None, true),
            other => {
                let problem =
                    format!("its alphaMode is `{other}`, but must be OPAQUE, MASK or BLEND");
                return Err(invalid(problem));
            }
        };
        let material = Material {
            base_color: Vec4::from_array(pbr.base_color_factor),
            base_color_texture: texture,
            metallic: pbr.metallic_factor,
            roughness: pbr.roughness_factor,
            alpha_cutoff,
            ..Material::plain("ggx")
        };
        material.check().map_err(invalid)?;
        let mut look = Look {
            cut: is_blended.then(|| {
                Arc::new(Material {
                    alpha_cutoff: Some(0.5),
                    ..material.clone()
                })
            }),
            material: Arc::new(material),
            uvs,
            place,
        };
        if let Some(cut) = look.cut.take_if(|cut| !is_opaque(cut)) {
            look.material = cut;
            self.note_blending(&look.place);
        }
        Ok(look)
    }

    /// The material of a mesh whose vertices have these colours. A blended material counts as opaque where nothing is
    /// less than opaque: exporters write blending for such surfaces all the same.
    pub(super) fn material(&self, look: &Look, colors: &[Vec4]) -> Arc<Material> {
        match &look.cut {
            Some(cut) if colors.iter().any(|color| color.w < 1.0) => {
                self.note_blending(&look.place);
                Arc::clone(cut)
            }
            _ => Arc::clone(&look.material),
        }
    }

    fn note_blending(&self, place: &str) {
        let instead = "surfaces are cut at half their opacity";
        self.notes.tell("alphaMode BLEND", instead, place);
    }

    /// A texture that `by` names; none where it has no picture.
    fn texture(
        &self,
        images: &mut BTreeMap<Whole, Arc<Image>>,
        index: Whole,
        by: &str,
    ) -> Result<Option<Texture>, SceneError> {
        let file: TextureFile = self.document.element("textures", index, by)?;
        let place = format!("textures[{}]", index.0);
        let Some(source) = file.source else {
            let instead = "surfaces have their colour without the texture";
            self.notes.tell("textures without a source", instead, place);
            return Ok(None);
        };
        let sampler: Sampler = match file.sampler {
            Some(sampler) => self.document.element("samplers", sampler, &place)?,
            None => Sampler::default(),
        };
        let wrap = |mode: Option<Whole>| match mode.map(|mode| mode.0) {
            None | Some(10497) => Ok(Wrap::Repeat),
            Some(33071) => Ok(Wrap::Clamp),
            Some(33648) => Ok(Wrap::Mirror),
            Some(other) => {
                let problem = format!("its sampler's wrapping mode {other} is none of glTF's");
                Err(self.document.invalid(&place, problem))
            }
        };
        const NEAREST: Whole = Whole(9728);
        let image = match images.get(&source) {
            Some(known) => Arc::clone(known),
            None => {
                let image = Arc::new(self.image(source, &place)?);
                images.insert(source, Arc::clone(&image));
                image
            }
        };
        Ok(Some(Texture {
            image,
            wrap: [wrap(sampler.wrap_s)?, wrap(sampler.wrap_t)?],
            smooth: sampler.mag_filter != Some(NEAREST),
        }))
    }

    fn image(&self, index: Whole, by: &str) -> Result<Image, SceneError> {
        let document = self.document;
        let image: ImageFile = document.element("images", index, by)?;
        let place = format!("images[{}]", index.0);
        match (&image.uri, image.buffer_view) {
            (Some(uri), _) => Image::decode(&document.load(&place, uri)?, document.path, &place),
            (None, Some(view)) => {
                Image::decode(document.view(view, &place)?.0, document.path, &place)
            }
            (None, None) => {
                Err(document.invalid(&place, "it has neither a file nor a buffer view"))
            }
        }
    }
}

/// Where the texture's coordinates are from, and how they are transformed.
fn uvs_of(info: &TextureInfo) -> Result<Uvs, String> {
    let mut uvs = Uvs {
        set: Some(info.tex_coord.0),
        transform: None,
    };
    if let Some(transform) = &info.extensions.transform {
        uvs.set = Some(transform.tex_coord.unwrap_or(info.tex_coord).0);
        // Counter-clockwise where v points down; the extension's page has a listing with the other sign, which
        // no loader follows (KhronosGroup/glTF issue 1563).
        let rotation = DMat2::from_angle(-transform.rotation);
        let scale = DMat2::from_diagonal(DVec2::from_array(transform.scale));
        let affine = DAffine2::from_mat2_translation(rotation * scale, transform.offset.into());
        if !affine.is_finite() {
            return Err("its texture's transform is not finite".to_owned());
        }
        uvs.transform = Some(affine);
    }
    Ok(uvs)
}

/// Whether nothing of the material is less than opaque.
fn is_opaque(material: &Material) -> bool {
    let texture = material.base_color_texture.as_ref();
    let texels = texture.and_then(|texture| texture.image.levels.first());
    let mut texels = texels.into_iter().flat_map(|level| &level.rgba);
    material.base_color.w >= 1.0 && texels.all(|texel| texel[3] == 255)
}

//! Draws a scene with a method, and measures what was drawn.

use std::{collections::BTreeMap, sync::Arc};

use glam::Vec3;
use umbrage_compose::{Composer, Key, Library, Over, Pass, Permutation, Purpose};
use umbrage_render::{
    Gpu, Picture, RenderError, RenderOptions, Rendered, Renderer, Scene, Shadow, What,
};
use umbrage_shadow::{LightKind, Registry, Support};

use super::{Config, StudyError};
use crate::{
    figures::{Figures, Sample, back_facing, figures, flip},
    report::{Pictures, difference},
    truth::Truth,
};

/// A device to draw on, what to compose shaders from, and the methods to measure.
pub struct Lab {
    composer: Arc<Composer>,
    registry: Registry,
    renderer: Renderer,
    /// Draws what the renderer's pictures are timed beside, with maps of its own.
    beside: Renderer,
    adapter: String,
}

/// One picture of a scene: what is true of it, and what the rasteriser sees.
pub(super) struct Subject<'a> {
    pub(super) scene: &'a Scene,
    pub(super) truth: &'a Truth,
    /// Object and triangle that the rasteriser drew in each pixel.
    pub(super) raster: Vec<Option<(u32, u32)>>,
}

/// A scene without its shadows, linear RGB.
pub(super) struct Unshadowed {
    /// In no light but the ambient.
    ambient: Vec<[f32; 3]>,
    /// Radiance that each light adds.
    lights: Vec<Vec<[f32; 3]>>,
}

impl Lab {
    /// A lab whose permutations come from `composer`.
    pub fn new(gpu: Arc<Gpu>, composer: Arc<Composer>, registry: Registry) -> Self {
        let adapter = gpu.adapter().to_owned();
        let renderer = || Renderer::new(Arc::clone(&gpu), Arc::clone(&composer), registry.clone());
        Self {
            renderer: renderer(),
            beside: renderer(),
            composer,
            registry,
            adapter,
        }
    }

    /// The methods that can be measured.
    pub fn registry(&self) -> &Registry {
        &self.registry
    }

    /// The shader library.
    pub fn library(&self) -> &Library {
        self.composer.library()
    }

    /// The adapter that is drawn on.
    pub fn adapter(&self) -> &str {
        &self.adapter
    }

    /// The lights of `scene` that cast shadows and that `config` can shadow, by their places, and why it cannot shadow the
    /// first of the others.
    pub(super) fn lights(
        &self,
        scene: &Scene,
        config: &Config,
    ) -> Result<(Vec<usize>, Option<String>), StudyError> {
        let method = self.registry.methods.get(&config.shadow.method)?;
        let (mut lights, mut refusal) = (Vec::new(), None);
        let casting = scene.lights.iter().enumerate();
        let mut casting = casting
            .filter(|(_, light)| scene.casts_shadow(light))
            .peekable();
        if casting.peek().is_none() {
            refusal = Some("no light of the scene casts shadows; give one a `shadow`".to_owned());
        }
        for (index, light) in casting {
            let supported = match method.supports(&light.light) {
                Support::Yes => self.excluded(&light.light.kind, config),
                Support::No(reason) => Some(reason),
            };
            match supported {
                None => lights.push(index),
                Some(reason) => {
                    refusal.get_or_insert(format!("light `{}`: {reason}", light.name));
                }
            }
        }
        Ok((lights, refusal))
    }

    /// Why the shader library excludes what is chosen for a method under a kind of light, where they do.
    fn excluded(&self, kind: &LightKind, config: &Config) -> Option<String> {
        if config.shadow.axes.is_empty() {
            return None;
        }
        let key = self.key("shadow_term", kind, config);
        key.err().map(|error| error.to_string())
    }

    /// The key of a pass under a kind of light.
    pub(super) fn key(
        &self,
        pass: &str,
        kind: &LightKind,
        config: &Config,
    ) -> Result<Key, umbrage_compose::Error> {
        let own = [
            ("pass", pass),
            ("light", kind.name()),
            ("method", config.shadow.method.as_str()),
        ];
        let chosen = config
            .shadow
            .axes
            .iter()
            .map(|(a, v)| (a.as_str(), v.as_str()));
        self.library().key(own.into_iter().chain(chosen))
    }

    /// The scene as the rasteriser sees it, beside its truth.
    pub(super) fn subject<'a>(
        &mut self,
        scene: &'a Scene,
        truth: &'a Truth,
    ) -> Result<Subject<'a>, RenderError> {
        let options = RenderOptions {
            what: What::Triangles,
            ..plain(truth)
        };
        let raster = match self.render(scene, &options)?.picture {
            Picture::Triangles(raster) => raster,
            _ => Vec::new(),
        };
        Ok(Subject {
            scene,
            truth,
            raster,
        })
    }

    /// The shadow terms, by lights, and what the methods planned.
    pub(super) fn terms(
        &mut self,
        subject: &Subject<'_>,
        options: &RenderOptions,
    ) -> Result<Rendered, RenderError> {
        let options = RenderOptions {
            what: What::ShadowTerm,
            ..options.clone()
        };
        self.render(subject.scene, &options)
    }

    /// Texture fetches a compared sample, counted on the device: the share of the samples that take so many.
    pub(super) fn fetches(
        &mut self,
        subject: &Subject<'_>,
        options: &RenderOptions,
    ) -> Result<BTreeMap<u32, f64>, RenderError> {
        let options = RenderOptions {
            what: What::Fetches,
            ..options.clone()
        };
        let counts = match self.render(subject.scene, &options)?.picture {
            Picture::Fetches(counts) => counts,
            _ => Vec::new(),
        };
        let mut samples = BTreeMap::<_, u64>::new();
        for count in subject.compared(&counts) {
            // A whole number, as it was counted.
            *samples.entry(count as u32).or_default() += 1;
        }
        let all: u64 = samples.values().sum();
        let shares = samples.into_iter();
        Ok(shares
            .map(|(count, samples)| (count, samples as f64 / all as f64))
            .collect())
    }

    /// The shaded picture, and how long its passes took: drawn where all else is drawn, or beside that.
    pub(super) fn timed(
        &mut self,
        subject: &Subject<'_>,
        options: &RenderOptions,
        is_own: bool,
    ) -> Result<Rendered, RenderError> {
        let renderer = if is_own {
            &mut self.renderer
        } else {
            &mut self.beside
        };
        let options = RenderOptions {
            timed: true,
            ..options.clone()
        };
        renderer.render(subject.scene, &options)
    }

    /// The scene without its shadows.
    pub(super) fn unshadowed(&mut self, subject: &Subject<'_>) -> Result<Unshadowed, RenderError> {
        let mut scene = subject.scene.clone();
        let lights = std::mem::take(&mut scene.lights);
        let ambient = self.plain_picture(&scene, subject)?;
        (scene.ambient, scene.background) = (Vec3::ZERO, Vec3::ZERO);
        let mut pictures = Vec::new();
        for light in lights {
            scene.lights = vec![light];
            pictures.push(self.plain_picture(&scene, subject)?);
        }
        Ok(Unshadowed {
            ambient,
            lights: pictures,
        })
    }

    fn plain_picture(
        &mut self,
        scene: &Scene,
        subject: &Subject<'_>,
    ) -> Result<Vec<[f32; 3]>, RenderError> {
        let options = plain(subject.truth);
        Ok(pixels(&self.render(scene, &options)?.picture).to_vec())
    }

    /// The permutations that light the surfaces of a picture.
    pub(super) fn illumination(
        &self,
        rendered: &Rendered,
    ) -> Result<Vec<Arc<Permutation>>, StudyError> {
        let lights = |pass: Pass| match pass.purpose {
            Purpose::Light => pass.over == Over::Objects,
            purpose => purpose == Purpose::Shadow,
        };
        let used = rendered.report.permutations.iter();
        let lit = used.filter(|used| self.library().axes().pass(&used.key).is_some_and(lights));
        lit.map(|used| Ok(self.composer.compose_all(&used.keys())?.permutation))
            .collect()
    }

    pub(super) fn compose(&self, key: &Key) -> Result<Arc<Permutation>, umbrage_compose::Error> {
        Ok(self.composer.compose(key)?.permutation)
    }

    pub(super) fn render(
        &mut self,
        scene: &Scene,
        options: &RenderOptions,
    ) -> Result<Rendered, RenderError> {
        self.renderer.render(scene, options)
    }
}

impl Subject<'_> {
    pub(super) fn size(&self) -> (u32, u32) {
        (self.truth.sight.width(), self.truth.sight.height())
    }

    /// Whether the rasteriser saw in a pixel what the ray saw.
    pub(super) fn agrees(&self, pixel: usize) -> bool {
        let seen = self.truth.sight.seen().get(pixel).copied().flatten();
        let seen = seen.map(|seen| (seen.object, seen.triangle));
        self.raster.get(pixel).copied().flatten() == seen
    }

    /// The places of the lights that cast shadows: what others have cannot be wrong.
    pub(super) fn casting(&self) -> impl Iterator<Item = usize> {
        let lights = self.scene.lights.iter().enumerate();
        let casting = lights.filter(|(_, light)| self.scene.casts_shadow(light));
        casting.map(|(index, _)| index)
    }

    /// Of `values`, by lights and pixels, those that are compared.
    pub(super) fn compared<T: Copy>(&self, values: &[Vec<T>]) -> impl Iterator<Item = T> {
        let lights = self.casting();
        let lights = lights.filter_map(|at| Some((values.get(at)?, self.truth.terms.get(at)?)));
        lights.flat_map(|(values, truth)| {
            let pixels = values.iter().zip(truth).enumerate();
            pixels.filter_map(|(pixel, (value, term))| {
                (term.is_some() && self.agrees(pixel)).then_some(*value)
            })
        })
    }

    /// The errors of the shadow terms in `rendered`.
    pub(super) fn figures(&self, rendered: &Rendered) -> Result<Figures, StudyError> {
        let terms = terms(rendered);
        let samples: Vec<_> = self
            .casting()
            .map(|index| Sample {
                light: &self.scene.lights[index].light,
                truth: &self.truth.terms[index],
                gaps: &self.truth.gaps[index],
                rendered: terms.get(index).map_or(&[], Vec::as_slice),
                plan: rendered.report.plans.get(index).and_then(Option::as_deref),
            })
            .collect();
        Ok(figures(
            self.scene,
            &self.truth.sight,
            &self.raster,
            &samples,
        )?)
    }

    /// How far a shaded picture is from what it would be with true shadows: mean FLIP. Pixels where the
    /// rasteriser saw another triangle than the ray are taken as they were rendered.
    pub(super) fn flip(
        &self,
        unshadowed: &Unshadowed,
        rendered: &Rendered,
    ) -> Result<f64, StudyError> {
        let shaded = pixels(&rendered.picture);
        let mut truth = self.shaded_truth(unshadowed);
        for (pixel, (truth, shaded)) in truth.iter_mut().zip(shaded).enumerate() {
            if !self.agrees(pixel) {
                *truth = *shaded;
            }
        }
        let (width, height) = self.size();
        Ok(flip(width, height, &truth, shaded)?)
    }

    /// The shaded picture with true shadows, linear RGB.
    pub(super) fn shaded_truth(&self, unshadowed: &Unshadowed) -> Vec<[f32; 3]> {
        let mut truth = unshadowed.ambient.clone();
        for (added, terms) in unshadowed.lights.iter().zip(&self.truth.terms) {
            for ((pixel, added), term) in truth.iter_mut().zip(added).zip(terms) {
                let term = term.unwrap_or(1.0);
                for (channel, added) in pixel.iter_mut().zip(added) {
                    *channel += term * added;
                }
            }
        }
        truth
    }

    /// Pictures that a report shows of a rendering: of several lights the product of their terms.
    pub(super) fn pictures(
        &self,
        rendered: &Rendered,
        shaded: Option<&Rendered>,
    ) -> Result<Pictures, StudyError> {
        let rendered = terms(rendered);
        let back_facing = back_facing(self.scene, &self.truth.sight)?;
        let pixels = 0..self.truth.sight.seen().len();
        // The product of the truths and that of what was drawn, over the lights that reach a pixel: what the method says of
        // others does not matter.
        let product = |pixel: usize, is_seen: &dyn Fn(usize) -> bool| {
            let lights = self.truth.terms.iter().zip(rendered).enumerate();
            let reached = lights.filter(|(light, _)| is_seen(*light));
            let reached =
                reached.filter_map(|(_, (truth, drawn))| Some((truth[pixel]?, drawn[pixel])));
            reached.reduce(|a, b| (a.0 * b.0, a.1 * b.1))
        };
        let split = |products: Vec<Option<(f32, f32)>>| {
            let products = products.into_iter();
            products
                .map(|product| {
                    (
                        product.map(|(truth, _)| truth),
                        product.map_or(1.0, |(_, drawn)| drawn),
                    )
                })
                .unzip::<_, _, Vec<_>, Vec<_>>()
        };
        let (truth, drawn) = split(
            pixels
                .clone()
                .map(|pixel| product(pixel, &|_| true))
                .collect(),
        );
        // Nobody sees an error where a light's side is turned away from it.
        let seen = pixels
            .clone()
            .map(|pixel| product(pixel, &|light| !back_facing[light][pixel]));
        let (true_seen, drawn_seen) = split(seen.collect());
        let compared: Vec<_> = pixels.map(|pixel| self.agrees(pixel)).collect();
        let (width, height) = self.size();
        let difference = difference(&true_seen, &drawn_seen, &compared, width, height)?;
        let shaded = shaded.map(|shaded| shaded.to_image().into_rgb8());
        Ok(Pictures::new(&truth, &drawn, difference, shaded.as_ref())?)
    }
}

/// The mean of numbers, by the share of each.
pub(super) fn mean(shares: &BTreeMap<u32, f64>) -> f64 {
    let parts = shares.iter();
    parts
        .map(|(number, share)| f64::from(*number) * share)
        .sum()
}

/// The shadow terms of a rendering, by lights.
pub(super) fn terms(rendered: &Rendered) -> &[Vec<f32>] {
    match &rendered.picture {
        Picture::ShadowTerm(terms) => terms,
        _ => &[],
    }
}

/// The colours of a shaded picture.
pub(super) fn pixels(picture: &Picture) -> &[[f32; 3]] {
    match picture {
        Picture::Shaded(pixels) => pixels,
        _ => &[],
    }
}

/// A picture without shadows, as large as the truth's.
fn plain(truth: &Truth) -> RenderOptions {
    RenderOptions {
        width: truth.sight.width(),
        height: truth.sight.height(),
        shadow: Shadow::new("none"),
        ..RenderOptions::default()
    }
}

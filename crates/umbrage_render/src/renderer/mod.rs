//! Renders a scene: shadow maps, then what the camera sees.

mod air;
mod assets;
mod bind;
mod camera;
mod draw;
mod frame;
mod lights;
mod lists;
mod masks;
mod meanwhile;
mod objects;
mod passes;
mod regions;
mod seen;
mod shadows;
mod target;
mod timer;

use std::{fmt, sync::Arc, time::Instant};

use glam::Mat4;
use umbrage_compose::Composer;
use umbrage_shadow::{Aabb, PlanError, Registry, View};
use umbrage_wgpu::{Executor, Shadow};

pub use self::meanwhile::{Meanwhile, StandIn};
use self::{
    assets::Assets,
    frame::FrameState,
    lights::LightSetup,
    objects::{Kept, Objects},
    target::{Target, Targets},
    timer::Timer,
};
use crate::{
    Gpu, Picture, RenderError, Rendered, Report,
    scene::{Image, Scene},
};

/// Renders scenes. What it makes on the device it keeps for the next picture.
pub struct Renderer {
    gpu: Arc<Gpu>,
    composer: Arc<Composer>,
    registry: Registry,
    assets: Assets,
    /// The objects of the last picture.
    objects: Kept,
    targets: Targets,
    /// Shadow maps, and all pipelines.
    executor: Executor,
    white: Arc<Image>,
    /// Pictures that were begun: each has a camera's depth of its own.
    pictures: u64,
}

/// Choices for a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderOptions {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Contents of the picture.
    pub what: What,
    /// Choices put over those of the lights' own: a method for all lights that [cast shadows](Scene::casts_shadow)
    /// ([`Shadow::NONE`] takes all shadows away, an empty one keeps the lights' own), and values of axes and settings. Here,
    /// axes may be no part's as well, and then hold wherever a permutation has them; one that is turned on without its
    /// texture reads white.
    pub shadow: Shadow,
    /// How shadow terms come to where light is added.
    pub path: Path,
    /// How many steps are made along each pixel's ray through a scene's [medium](crate::Medium), for each light: 1 to
    /// [`MOST_SHAFT_STEPS`]. Each looks up the light's shadow once. The grain that is left where shafts begin and end
    /// falls with their number: in `examples/scenes/shafts.ron`, against 4096 steps, it is 0.0066 (root mean square, of 1)
    /// at 32 steps and 0.0030 at 64, less than a code of 255 in linear light.
    pub shaft_steps: u32,
    /// Whether shadow maps are drawn though they stand already, as if all casters had moved: what a measurement of the whole
    /// cost wants.
    pub fresh: bool,
    /// Drawing of lights' passes while pipelines are made that a picture needs for the first time.
    pub meanwhile: Meanwhile,
    /// Whether the device takes the time of each pass, for [`Report::times`](crate::Report::times):
    /// that costs a little time itself.
    pub timed: bool,
}

/// The most steps that a ray through a medium may have.
pub const MOST_SHAFT_STEPS: u32 = 4096;

/// Contents of a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum What {
    /// The scene.
    #[default]
    Shaded,
    /// For each light its shadow term alone.
    ShadowTerm,
    /// Which triangle each pixel sees.
    Triangles,
    /// For each light the texture fetches that its shadow term takes, counted on the device.
    Fetches,
    /// For each light how its shadow term was found: see [`Decision`](crate::Decision).
    Decisions,
    /// For each light the texture fetches that its shafts take: for every step those of the shadow term and of a
    /// cookie, and one for the depth of what is seen.
    ShaftFetches,
    /// The scene, and for each light which of its several shadow maps is read.
    Splits,
}

/// How the shadow terms of a [shaded](What::Shaded) picture, and [by themselves](What::ShadowTerm), come
/// about. The methods do not know which it is, and the pictures are the same up to rounding: the mask
/// path finds a position again from linear depth, along the ray through the pixel's middle, and a
/// rasteriser's own may be off by its grid, 1/256 pixel on most devices.
#[derive(
    serde::Deserialize,
    serde::Serialize,
    Clone,
    Copy,
    Debug,
    Default,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
)]
#[serde(rename_all = "snake_case")]
pub enum Path {
    /// Where an object is lit, by its own shader: `calc_shadow` for every fragment that is lit, in a pass for each light.
    #[default]
    Forward,
    /// The same in one pass for all lights: an object is drawn once, by a shader that adds up the lights that reach it, as
    /// many as the target's limits allow, then once more for those beyond.
    ForwardAll,
    /// In a pass of its own over the picture, into a shadow mask that the object's shader reads: one
    /// permutation a light and method, whatever the surfaces; for
    /// [`mask_bytes`](crate::Report::mask_bytes) more memory, and one more pass over the objects.
    Mask,
    /// The same, by a pass over the picture for each of the plan's
    /// [regions](umbrage_shadow::ShadowPlan::regions), with its own permutation; the depth test rejects the pixels of
    /// the others before they are shaded. A light whose plan has none has the one pass of the mask path.
    MaskBySplit,
}

impl Path {
    /// All of them.
    pub const ALL: [Self; 4] = [
        Self::Forward,
        Self::ForwardAll,
        Self::Mask,
        Self::MaskBySplit,
    ];

    /// Whether shadow terms are found before light is added.
    pub fn has_masks(self) -> bool {
        matches!(self, Self::Mask | Self::MaskBySplit)
    }

    /// As configurations and reports spell it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Forward => "forward",
            Self::ForwardAll => "forward_all",
            Self::Mask => "mask",
            Self::MaskBySplit => "mask_by_split",
        }
    }
}

impl fmt::Display for Path {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl Default for RenderOptions {
    fn default() -> Self {
        Self {
            width: 640,
            height: 480,
            what: What::Shaded,
            shadow: Shadow::default(),
            path: Path::Forward,
            shaft_steps: 64,
            fresh: false,
            meanwhile: Meanwhile::Stall,
            timed: false,
        }
    }
}

/// Everything that one picture is rendered from.
struct Shot<'a> {
    scene: &'a Scene,
    view: View,
    view_proj: Mat4,
    lights: Vec<LightSetup<'a>>,
}

impl Renderer {
    /// A renderer whose permutations come from `composer` and whose shadow methods from `registry`.
    pub fn new(gpu: Arc<Gpu>, composer: Arc<Composer>, registry: Registry) -> Self {
        let executor = Executor::new(&gpu.device, &gpu.queue, Arc::clone(&composer));
        Self {
            gpu,
            composer,
            registry,
            assets: Assets::default(),
            objects: Kept::default(),
            targets: Targets::default(),
            executor,
            white: Arc::new(Image::white()),
            pictures: 0,
        }
    }

    /// Renders `scene`. The same input gives the same picture on the same adapter.
    ///
    /// # Errors
    /// A picture of no pixels or too many, lights that ask for methods, axes or settings that do not
    /// exist, shaders that cannot be composed, and what the device refuses.
    pub fn render(
        &mut self,
        scene: &Scene,
        options: &RenderOptions,
    ) -> Result<Rendered, RenderError> {
        let started = Instant::now();
        let mut rendered = self.checked(options, |renderer| {
            let (picture, report) = renderer.picture(scene, options)?;
            Ok(Rendered {
                width: options.width,
                height: options.height,
                picture,
                adapter: renderer.gpu.adapter().to_owned(),
                report,
            })
        })?;
        rendered.report.milliseconds = 1e3 * started.elapsed().as_secs_f64();
        Ok(rendered)
    }

    /// Draws `scene`, [shaded](What::Shaded), into somebody's own texture, and submits that without waiting for it: a frame
    /// of a steady loop. Linear RGB, as the texture's format takes it; opacity is 1. It waits only where a light's shadow asks
    /// what is on the device, and takes no times.
    ///
    /// `view` is of all of a texture of `options`' size, of one sample, that a pass may draw into and blend.
    ///
    /// # Errors
    /// As [`render`](Self::render)'s; another kind of picture; a texture of another size.
    ///
    /// ```no_run
    /// # use umbrage_render::*;
    /// # fn frame(renderer: &mut Renderer, scene: &Scene, texture: &wgpu::Texture) -> Result<(), RenderError> {
    /// let options = RenderOptions {
    ///     width: texture.width(),
    ///     height: texture.height(),
    ///     ..RenderOptions::default()
    /// };
    /// let report = renderer.draw(scene, &options, &texture.create_view(&Default::default()))?;
    /// println!("{} draws", report.draws);
    /// # Ok(())
    /// # }
    /// ```
    pub fn draw(
        &mut self,
        scene: &Scene,
        options: &RenderOptions,
        view: &wgpu::TextureView,
    ) -> Result<Report, RenderError> {
        let started = Instant::now();
        let texture = view.texture();
        let is_fit = [texture.width(), texture.height()] == [options.width, options.height]
            && texture.sample_count() == 1
            && options.what == What::Shaded;
        if !is_fit {
            return Err(RenderError::Target {
                what: options.what,
                expected: [options.width, options.height],
                found: [texture.width(), texture.height()],
                samples: texture.sample_count(),
            });
        }
        let mut report = self.checked(options, |renderer| {
            let shot = renderer.shot(scene, options)?;
            let mut frame = renderer.frame(&shot, options, false);
            let target = Target::onto(&renderer.gpu, &mut renderer.targets, view.clone())?;
            renderer.shade(&mut frame, &shot, &target)?;
            renderer.send(&mut frame);
            Ok(renderer.end(&shot, frame))
        })?;
        report.milliseconds = 1e3 * started.elapsed().as_secs_f64();
        Ok(report)
    }

    /// Does `work` for a picture, the options checked. After an error nothing is kept that may be broken by it.
    fn checked<T>(
        &mut self,
        options: &RenderOptions,
        work: impl FnOnce(&mut Self) -> Result<T, RenderError>,
    ) -> Result<T, RenderError> {
        let limit = self.gpu.device.limits().max_texture_dimension_2d;
        let (width, height) = (options.width, options.height);
        if !(1..=limit).contains(&width) || !(1..=limit).contains(&height) {
            return Err(RenderError::Size {
                width,
                height,
                limit,
            });
        }
        let steps = options.shaft_steps;
        if !(1..=MOST_SHAFT_STEPS).contains(&steps) {
            return Err(RenderError::Steps { steps });
        }
        self.assets.sweep();
        self.pictures += 1;
        self.executor.begin_frame();
        self.targets.begin_frame();
        let gpu = Arc::clone(&self.gpu);
        let done = gpu.check(|| work(self));
        if done.is_err() {
            // Things made along with the error may be broken.
            self.assets = Assets::default();
            self.objects = Kept::default();
            self.targets = Targets::default();
            self.executor.clear();
        } else if matches!(done, Ok(Err(_))) {
            // Recorded passes into shadow maps were not drawn.
            self.executor.retain(|_| false);
        }
        done?
    }

    fn picture(
        &mut self,
        scene: &Scene,
        options: &RenderOptions,
    ) -> Result<(Picture, Report), RenderError> {
        let shot = self.shot(scene, options)?;
        let mut frame = self.frame(&shot, options, options.timed);
        let picture = match options.what {
            What::Shaded => self.shaded(&mut frame, &shot)?,
            What::ShadowTerm => self.shadow_terms(&mut frame, &shot)?,
            What::Triangles => self.triangles(&mut frame, &shot)?,
            What::Fetches => self.fetches(&mut frame, &shot)?,
            What::Decisions => self.decisions(&mut frame, &shot)?,
            What::ShaftFetches => self.shaft_fetches(&mut frame, &shot)?,
            What::Splits => self.splits(&mut frame, &shot)?,
        };
        Ok((picture, self.end(&shot, frame)))
    }

    /// All that a picture of `scene` is rendered from, checked.
    fn shot<'a>(&self, scene: &'a Scene, options: &RenderOptions) -> Result<Shot<'a>, RenderError> {
        let library = self.composer.library();
        let lights = lights::set_up(scene, options, &self.registry, library)?;
        let view = scene.view(options.width, options.height);
        check(scene, &view)?;
        let view_proj = view.view_proj_relative().as_mat4();
        Ok(Shot {
            scene,
            view,
            view_proj,
            lights,
        })
    }

    /// The beginning of a frame.
    fn frame<'a>(
        &mut self,
        shot: &Shot<'a>,
        options: &'a RenderOptions,
        timed: bool,
    ) -> FrameState<'a> {
        let view = &shot.view;
        let rays = masks::rays(view, options);
        let rays = match &shot.scene.medium {
            Some(medium) => air::constants(rays, view, medium, options),
            None => rays,
        };
        let kept = std::mem::take(&mut self.objects);
        let mut objects = Objects::new(shot.scene, view.position, kept);
        let frustum = view.frustum_relative();
        objects.look(|bounds| frustum.intersects(&bounds.translate(-view.position)));
        FrameState::new(
            options,
            objects,
            self.gpu.device.create_command_encoder(&Default::default()),
            Timer::new(&self.gpu, timed),
            rays,
            view.projection.is_orthographic(),
        )
    }

    /// Ends a frame: keeps what the next one may use of it.
    fn end(&mut self, shot: &Shot<'_>, mut frame: FrameState<'_>) -> Report {
        self.executor
            .retain(|light| frame.shadow_maps.contains(&light));
        frame.report.plans.resize(shot.lights.len(), None);
        self.objects = frame.objects.keep();
        frame.report
    }
}

/// Checks the camera and the objects of a scene, which may have been made by hand.
fn check(scene: &Scene, view: &View) -> Result<(), RenderError> {
    view.validate().map_err(|source| RenderError::Scene {
        what: "the camera".to_owned(),
        source,
    })?;
    if let Some(medium) = &scene.medium {
        medium.validate().map_err(|source| RenderError::Scene {
            what: "the medium".to_owned(),
            source,
        })?;
    }
    for object in &scene.objects {
        let Aabb { min, max } = object.bounds;
        if object.bounds.is_finite() && object.transform.is_finite() {
            continue;
        }
        PlanError::check(
            false,
            "its box",
            format!("{min} to {max}"),
            "finite, as its transform must be",
        )
        .map_err(|source| RenderError::Scene {
            what: format!("object `{}`", object.name),
            source,
        })?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use umbrage_compose::{Library, Target};

    use super::*;

    /// Things kept on the device. Holding it keeps others from getting its place.
    #[derive(Debug, PartialEq)]
    struct Kept {
        meshes: Vec<wgpu::Buffer>,
        images: Vec<wgpu::TextureView>,
        pipelines: Vec<wgpu::RenderPipeline>,
        shadow_maps: Vec<wgpu::Texture>,
    }

    impl Kept {
        fn by(renderer: &Renderer) -> Self {
            let (mut meshes, mut images) = renderer.assets.kept();
            meshes.sort_unstable();
            images.sort_unstable();
            let pipelines = renderer.executor.pipelines();
            let mut pipelines: Vec<_> = pipelines.map(|kept| kept.pipeline.clone()).collect();
            pipelines.sort_unstable();
            Self {
                meshes,
                images,
                pipelines,
                shadow_maps: renderer.executor.textures().cloned().collect(),
            }
        }
    }

    /// A moved camera makes no pipeline, no mesh, no picture and no shadow map anew.
    #[test]
    fn what_stays_the_same_is_kept() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples");
        let package = umbrage_shader_lib::package().expect("the shader library");
        let library = Library::new([package]).expect("the library");
        let composer = Arc::new(Composer::new(library, Target::default()));
        let methods = umbrage_methods::registry().expect("names are unique");
        let gpu = Arc::new(Gpu::new().expect("an adapter"));
        let mut renderer = Renderer::new(gpu, composer, methods);
        let mut scene = Scene::load(folder.join("scenes/leaves.ron")).expect("a sound scene");
        scene.medium = Some(crate::Medium {
            scattering: 0.1,
            absorption: 0.0,
            anisotropy: 0.0,
        });
        for what in [
            What::Shaded,
            What::ShadowTerm,
            What::Triangles,
            What::Fetches,
            What::ShaftFetches,
            What::Splits,
        ] {
            let options = RenderOptions {
                width: 40,
                height: 30,
                what,
                ..RenderOptions::default()
            };
            renderer.render(&scene, &options).expect("renders");
            let before = Kept::by(&renderer);
            let some = [
                before.meshes.is_empty(),
                before.images.is_empty(),
                before.pipelines.is_empty(),
                before.shadow_maps.is_empty(),
            ];
            assert_eq!(some, [false, false, false, what == What::Triangles]);
            scene.camera.position.x += 1e-3;
            renderer.render(&scene, &options).expect("renders");
            assert_eq!(Kept::by(&renderer), before, "{what:?}");
        }
    }
}

//! Renders a scene: shadow maps, then what the camera sees.

mod assets;
mod draw;
mod lights;
mod objects;
mod pipelines;
mod shadows;
mod target;

use std::{
    collections::{BTreeMap, BTreeSet, HashMap},
    sync::Arc,
    time::Instant,
};

use glam::{Mat4, Vec3};
use umbrage_compose::{Composer, Key};
use umbrage_shadow::{Aabb, PlanError, Registry, TextureDesc, View};

use self::{
    assets::Assets,
    draw::{FrameState, LightInputs, PassInputs, record, unfiltered},
    lights::LightSetup,
    objects::Objects,
    pipelines::{DrawState, Pipeline},
    shadows::{ShadowResources, TextureId},
    target::{DEPTH, Target},
};
use crate::{
    Gpu, Picture, RenderError, Rendered,
    scene::{Image, Scene},
};

/// Renders scenes. What it makes on the device it keeps for the next picture.
pub struct Renderer {
    gpu: Arc<Gpu>,
    composer: Arc<Composer>,
    registry: Registry,
    assets: Assets,
    pipelines: HashMap<(Key, DrawState), Arc<Pipeline>>,
    shadow_maps: BTreeMap<TextureId, (TextureDesc, wgpu::Texture)>,
    white: Arc<Image>,
}

/// What to render.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderOptions {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// What the picture shows.
    pub what: What,
    /// A shadow method for all lights in place of the scene's; `none` takes all shadows away.
    pub method: Option<String>,
    /// Values for axes of the shader library, put in place of the scene's wherever a permutation has
    /// the axis. An axis that is turned on without its texture reads white.
    pub axes: BTreeMap<String, String>,
    /// Values for settings of the lights' methods, put in place of the scene's.
    pub settings: BTreeMap<String, f64>,
}

/// What a picture shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum What {
    /// The scene.
    #[default]
    Shaded,
    /// For each light its shadow term alone.
    ShadowTerm,
}

impl Default for RenderOptions {
    fn default() -> Self {
        Self {
            width: 640,
            height: 480,
            what: What::Shaded,
            method: None,
            axes: BTreeMap::new(),
            settings: BTreeMap::new(),
        }
    }
}

/// What one picture is rendered from.
struct Shot<'a> {
    scene: &'a Scene,
    view: View,
    view_proj: Mat4,
    lights: Vec<LightSetup<'a>>,
    /// Slots of what may be seen.
    visible: Vec<usize>,
}

impl Renderer {
    /// A renderer whose permutations come from `composer` and whose shadow methods from `registry`.
    pub fn new(gpu: Arc<Gpu>, composer: Arc<Composer>, registry: Registry) -> Self {
        Self {
            gpu,
            composer,
            registry,
            assets: Assets::default(),
            pipelines: HashMap::new(),
            shadow_maps: BTreeMap::new(),
            white: Arc::new(Image::white()),
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
        let limit = self.gpu.device.limits().max_texture_dimension_2d;
        let (width, height) = (options.width, options.height);
        if !(1..=limit).contains(&width) || !(1..=limit).contains(&height) {
            return Err(RenderError::Size {
                width,
                height,
                limit,
            });
        }
        self.assets.sweep();
        let gpu = Arc::clone(&self.gpu);
        let done = gpu.check(|| self.render_unchecked(scene, options));
        if done.is_err() {
            // What was made along with the error may be broken.
            self.assets = Assets::default();
            self.pipelines.clear();
            self.shadow_maps.clear();
        }
        let mut rendered = done??;
        rendered.report.milliseconds = 1e3 * started.elapsed().as_secs_f64();
        Ok(rendered)
    }

    fn render_unchecked(
        &mut self,
        scene: &Scene,
        options: &RenderOptions,
    ) -> Result<Rendered, RenderError> {
        // The methods must outlive the borrow of what is cached beside them.
        let registry = self.registry.clone();
        let library = self.composer.library();
        let lights = lights::set_up(scene, options, &registry, library)?;
        let view = scene.camera.view(options.width, options.height);
        check(scene, &view)?;
        let objects = Objects::new(scene, view.position);
        let frustum = view.frustum_relative();
        let near = |bounds: Aabb| bounds.translate(-view.position);
        let visible = objects
            .iter()
            .filter(|(_, object)| frustum.intersects(&near(object.bounds)))
            .map(|(slot, _)| slot)
            .collect();
        let view_proj = view.view_proj_relative().as_mat4();
        let shot = Shot {
            scene,
            view,
            view_proj,
            lights,
            visible,
        };
        let encoder = self.gpu.device.create_command_encoder(&Default::default());
        let mut frame = FrameState::new(options, objects, encoder);
        let picture = match options.what {
            What::Shaded => self.shaded(&mut frame, &shot)?,
            What::ShadowTerm => self.shadow_terms(&mut frame, &shot)?,
        };
        self.shadow_maps
            .retain(|id, _| frame.shadow_maps.contains(id));
        frame.report.plans.resize(shot.lights.len(), None);
        Ok(Rendered {
            width: options.width,
            height: options.height,
            picture,
            adapter: self.gpu.adapter().to_owned(),
            report: frame.report,
        })
    }

    fn shaded(
        &mut self,
        frame: &mut FrameState<'_>,
        shot: &Shot<'_>,
    ) -> Result<Picture, RenderError> {
        let format = wgpu::TextureFormat::Rgba16Float;
        let target = Target::new(&self.gpu, frame.options.width, frame.options.height, format)?;
        let background = shot.scene.background.as_dvec3();
        let clear = wgpu::Color {
            r: background.x,
            g: background.y,
            b: background.z,
            a: 1.0,
        };
        let base = PassInputs {
            pass: "base",
            cause: None,
            view_proj: shot.view_proj,
            ambient: shot.scene.ambient,
            light: None,
            state: camera_state(format, false, None),
        };
        let commands = self.prepare(frame, &base, &shot.visible)?;
        record(
            &mut target.begin(&mut frame.encoder, Some(clear)),
            &commands,
        );
        frame.report.passes += 1;
        for light in &shot.lights {
            let lit = lit(frame, shot, light);
            if lit.is_empty() {
                continue;
            }
            let shadow = self.shadow(frame, shot, light, &lit)?;
            let constants = lights::constants(&light.source.light, shot.view.position);
            let inputs = PassInputs {
                pass: "illumination",
                cause: Some(&light.source.name),
                view_proj: shot.view_proj,
                ambient: Vec3::ZERO,
                light: Some(LightInputs {
                    setup: light,
                    constants: &constants,
                    shadow: shadow.as_ref(),
                }),
                state: camera_state(format, true, shadow.as_ref()),
            };
            let commands = self.prepare(frame, &inputs, &lit)?;
            record(&mut target.begin(&mut frame.encoder, None), &commands);
            frame.report.passes += 1;
        }
        let bytes = self.finish(frame, &target)?;
        let half = |b: &[u8]| half::f16::from_le_bytes([b[0], b[1]]).to_f32();
        let pixel = |b: &[u8]| [half(&b[0..2]), half(&b[2..4]), half(&b[4..6])];
        Ok(Picture::Shaded(bytes.chunks_exact(8).map(pixel).collect()))
    }

    fn shadow_terms(
        &mut self,
        frame: &mut FrameState<'_>,
        shot: &Shot<'_>,
    ) -> Result<Picture, RenderError> {
        let format = wgpu::TextureFormat::R32Float;
        let target = Target::new(&self.gpu, frame.options.width, frame.options.height, format)?;
        let mut terms = Vec::new();
        for light in &shot.lights {
            let lit = lit(frame, shot, light);
            let shadow = if lit.is_empty() {
                None
            } else {
                self.shadow(frame, shot, light, &lit)?
            };
            let constants = lights::constants(&light.source.light, shot.view.position);
            // What the light does not reach is drawn for no light's sake.
            let inputs = |reads: Option<_>, state| PassInputs {
                pass: "shadow_term",
                cause: reads.is_some().then_some(light.source.name.as_str()),
                view_proj: shot.view_proj,
                ambient: Vec3::ZERO,
                light: reads,
                state,
            };
            let own = LightInputs {
                setup: light,
                constants: &constants,
                shadow: shadow.as_ref(),
            };
            let state = camera_state(format, false, shadow.as_ref());
            let mut commands = self.prepare(frame, &inputs(Some(own), state), &lit)?;
            // What the light does not reach hides what lies behind it, and is shaded by nothing.
            let unlit: Vec<_> = shot
                .visible
                .iter()
                .copied()
                .filter(|s| lit.binary_search(s).is_err())
                .collect();
            let state = camera_state(format, false, None);
            commands.extend(self.prepare(frame, &inputs(None, state), &unlit)?);
            record(
                &mut target.begin(&mut frame.encoder, Some(wgpu::Color::WHITE)),
                &commands,
            );
            frame.report.passes += 1;
            let bytes = self.finish(frame, &target)?;
            let term = |b: &[u8]| f32::from_le_bytes([b[0], b[1], b[2], b[3]]);
            terms.push(bytes.chunks_exact(4).map(term).collect());
        }
        Ok(Picture::ShadowTerm(terms))
    }

    /// Draws a light's shadow maps, where it has a method.
    fn shadow(
        &mut self,
        frame: &mut FrameState<'_>,
        shot: &Shot<'_>,
        light: &LightSetup<'_>,
        lit: &[usize],
    ) -> Result<Option<ShadowResources>, RenderError> {
        match &light.method {
            Some(setup) => self.cast(frame, &shot.view, light, setup, lit).map(Some),
            None => Ok(None),
        }
    }

    /// Runs what was recorded, and reads the colours back.
    fn finish(&self, frame: &mut FrameState<'_>, target: &Target) -> Result<Vec<u8>, RenderError> {
        let next = self.gpu.device.create_command_encoder(&Default::default());
        let encoder = std::mem::replace(&mut frame.encoder, next);
        self.gpu.queue.submit([encoder.finish()]);
        Ok(target.read(&self.gpu)?)
    }
}

/// Checks the camera and the objects of a scene, which may have been made by hand.
fn check(scene: &Scene, view: &View) -> Result<(), RenderError> {
    view.validate().map_err(|source| RenderError::Scene {
        what: "the camera".to_owned(),
        source,
    })?;
    for object in &scene.objects {
        let Aabb { min, max } = object.bounds;
        PlanError::check(
            object.bounds.is_finite() && object.transform.is_finite(),
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

/// The slots of what may be seen and is reached by `light`.
fn lit(frame: &FrameState<'_>, shot: &Shot<'_>, light: &LightSetup<'_>) -> Vec<usize> {
    let reached = |bounds| light.source.light.reaches(bounds);
    let slots = frame.objects.iter().filter(|(slot, object)| {
        shot.visible.binary_search(slot).is_ok() && reached(&object.bounds)
    });
    slots.map(|(slot, _)| slot).collect()
}

/// How the camera's passes draw: nearest wins, depth reversed, both sides of a triangle seen. A
/// pass that adds light meets the depth that the base pass left, computed alike.
fn camera_state(
    format: wgpu::TextureFormat,
    additive: bool,
    shadow: Option<&ShadowResources>,
) -> DrawState {
    DrawState {
        color: Some((format, additive)),
        depth: DEPTH,
        compare: wgpu::CompareFunction::GreaterEqual,
        write_depth: !additive,
        cull: None,
        front: wgpu::FrontFace::Ccw,
        unfiltered: if shadow.is_some() {
            unfiltered(shadow)
        } else {
            BTreeSet::new()
        },
    }
}

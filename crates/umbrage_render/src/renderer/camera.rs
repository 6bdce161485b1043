//! The camera's passes: one function a kind of picture.

use std::{collections::BTreeSet, time::Instant};

use glam::Vec3;

use super::{
    Renderer, Shot,
    assets::Vertices,
    draw::{Command, FrameState, LightInputs, PassInputs, record},
    lights::{self, LightSetup},
    pipelines::{ADD, ColorState, DrawState},
    resources::{ShadowResources, unfiltered},
    target::{DEPTH, Target},
};
use crate::{Decision, Picture, RenderError};

impl Renderer {
    pub(super) fn shaded(
        &mut self,
        frame: &mut FrameState<'_>,
        shot: &Shot<'_>,
    ) -> Result<Picture, RenderError> {
        let format = wgpu::TextureFormat::Rgba16Float;
        let target = self.target(frame, format)?;
        let background = shot.scene.background.as_dvec3();
        let clear = wgpu::Color {
            r: background.x,
            g: background.y,
            b: background.z,
            a: 1.0,
        };
        let base = PassInputs {
            ambient: shot.scene.ambient,
            ..inputs(shot, "base", None, camera_state(format, false, None))
        };
        let commands = self.prepare(frame, &base, &shot.visible)?;
        self.draw(frame, &target, (base.pass, None), Some(clear), &commands);
        let mut masks = None;
        for light in &shot.lights {
            let lit = lit(frame, shot, light);
            if lit.is_empty() {
                continue;
            }
            let shadow = self.shadow(frame, shot, light, &lit)?;
            let constants = lights::constants(&light.source.light, shot.view.position);
            let reads = LightInputs {
                setup: light,
                constants: &constants,
                shadow: shadow.as_ref(),
                masked: false,
            };
            let to = (&target, false);
            let mask = self.mask(frame, shot, to, &mut masks, (reads, &lit))?;
            let reads = masked(reads, mask.as_ref());
            let state = camera_state(format, true, reads.shadow);
            let inputs = inputs(shot, "illumination", Some(reads), state);
            let commands = self.prepare(frame, &inputs, &lit)?;
            self.draw(frame, &target, (inputs.pass, inputs.cause), None, &commands);
        }
        let bytes = self.finish(frame, &target)?;
        let half = |b: &[u8]| half::f16::from_le_bytes([b[0], b[1]]).to_f32();
        let pixel = |b: &[u8]| [half(&b[0..2]), half(&b[2..4]), half(&b[4..6])];
        Ok(Picture::Shaded(bytes.chunks_exact(8).map(pixel).collect()))
    }

    pub(super) fn shadow_terms(
        &mut self,
        frame: &mut FrameState<'_>,
        shot: &Shot<'_>,
    ) -> Result<Picture, RenderError> {
        let terms = self.by_light(frame, shot, "shadow_term", wgpu::Color::WHITE)?;
        Ok(Picture::ShadowTerm(terms))
    }

    pub(super) fn fetches(
        &mut self,
        frame: &mut FrameState<'_>,
        shot: &Shot<'_>,
    ) -> Result<Picture, RenderError> {
        let counts = self.by_light(frame, shot, "fetch_count", wgpu::Color::TRANSPARENT)?;
        Ok(Picture::Fetches(counts))
    }

    pub(super) fn decisions(
        &mut self,
        frame: &mut FrameState<'_>,
        shot: &Shot<'_>,
    ) -> Result<Picture, RenderError> {
        let numbers = self.by_light(frame, shot, "decision", wgpu::Color::TRANSPARENT)?;
        let decisions = |light: Vec<f32>| light.into_iter().map(Decision::of).collect();
        Ok(Picture::Decisions(
            numbers.into_iter().map(decisions).collect(),
        ))
    }

    /// What `pass` gives for each light and pixel; red's `clear` where nothing is seen.
    fn by_light(
        &mut self,
        frame: &mut FrameState<'_>,
        shot: &Shot<'_>,
        pass: &str,
        clear: wgpu::Color,
    ) -> Result<Vec<Vec<f32>>, RenderError> {
        let format = wgpu::TextureFormat::R32Float;
        let target = self.target(frame, format)?;
        let mut pictures = Vec::new();
        let mut masks = None;
        for light in &shot.lights {
            let lit = lit(frame, shot, light);
            let shadow = if lit.is_empty() {
                None
            } else {
                self.shadow(frame, shot, light, &lit)?
            };
            let constants = lights::constants(&light.source.light, shot.view.position);
            let reads = LightInputs {
                setup: light,
                constants: &constants,
                shadow: shadow.as_ref(),
                masked: false,
            };
            // What is counted is what a method fetches, and no mask is one.
            let mask = if pass == "shadow_term" {
                self.mask(frame, shot, (&target, true), &mut masks, (reads, &lit))?
            } else {
                None
            };
            let reads = masked(reads, mask.as_ref());
            let state = camera_state(format, false, reads.shadow);
            let mut commands =
                self.prepare(frame, &inputs(shot, pass, Some(reads), state), &lit)?;
            // What the light does not reach hides what lies behind it, is shaded by nothing, and is drawn
            // for no light's sake.
            let unlit: Vec<_> = shot
                .visible
                .iter()
                .copied()
                .filter(|s| lit.binary_search(s).is_err())
                .collect();
            let state = camera_state(format, false, None);
            commands.extend(self.prepare(frame, &inputs(shot, pass, None, state), &unlit)?);
            let name = Some(light.source.name.as_str());
            self.draw(frame, &target, (pass, name), Some(clear), &commands);
            let bytes = self.finish(frame, &target)?;
            let pixels = bytes.as_chunks::<4>().0.iter().copied();
            pictures.push(pixels.map(f32::from_le_bytes).collect());
        }
        Ok(pictures)
    }

    pub(super) fn triangles(
        &mut self,
        frame: &mut FrameState<'_>,
        shot: &Shot<'_>,
    ) -> Result<Picture, RenderError> {
        // No list of objects is so long that its last would have this number.
        const NOTHING: u32 = u32::MAX;
        let format = wgpu::TextureFormat::Rg32Uint;
        let target = self.target(frame, format)?;
        let inputs = PassInputs {
            vertices: Vertices::Own,
            ..inputs(shot, "triangle", None, camera_state(format, false, None))
        };
        let clear = wgpu::Color {
            r: NOTHING.into(),
            ..wgpu::Color::TRANSPARENT
        };
        let commands = self.prepare(frame, &inputs, &shot.visible)?;
        self.draw(frame, &target, (inputs.pass, None), Some(clear), &commands);
        let bytes = self.finish(frame, &target)?;
        let words = bytes.as_chunks::<4>().0.iter().copied();
        let words: Vec<_> = words.map(u32::from_le_bytes).collect();
        let seen = |[slot, triangle]: &[u32; 2]| {
            let object = frame.objects.index(*slot as usize)?;
            Some((object as u32, *triangle))
        };
        let pixels = words.as_chunks::<2>().0.iter();
        Ok(Picture::Triangles(pixels.map(seen).collect()))
    }

    fn target(
        &self,
        frame: &FrameState<'_>,
        format: wgpu::TextureFormat,
    ) -> Result<Target, RenderError> {
        Target::new(&self.gpu, frame.options.width, frame.options.height, format)
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

    /// Records `pass`, drawn for a light where it names one.
    fn draw(
        &self,
        frame: &mut FrameState<'_>,
        target: &Target,
        (pass, light): (&str, Option<&str>),
        clear: Option<wgpu::Color>,
        commands: &[Command],
    ) {
        let mark = frame.timer.mark(&self.gpu, pass, light);
        record(
            &mut target.begin(&mut frame.encoder, clear, mark.as_ref()),
            commands,
        );
        frame.report.passes += 1;
    }

    /// Runs what was recorded, and reads the colours back.
    fn finish(&self, frame: &mut FrameState<'_>, target: &Target) -> Result<Vec<u8>, RenderError> {
        let next = self.gpu.device.create_command_encoder(&Default::default());
        let mut encoder = std::mem::replace(&mut frame.encoder, next);
        let times = frame.timer.resolve(&self.gpu, &mut encoder);
        let recorded = encoder.finish();
        let started = Instant::now();
        self.gpu.queue.submit([recorded]);
        self.gpu.wait()?;
        frame.report.gpu_milliseconds += 1e3 * started.elapsed().as_secs_f64();
        if let Some(times) = times {
            let times = frame.timer.read(&self.gpu, &times)?;
            frame.report.times.extend(times);
        }
        Ok(target.read(&self.gpu)?)
    }
}

/// What the camera's pass draws with: for the light that it `reads`, if it does.
fn inputs<'a>(
    shot: &Shot<'_>,
    pass: &'a str,
    reads: Option<LightInputs<'a>>,
    state: DrawState,
) -> PassInputs<'a> {
    PassInputs {
        pass,
        cause: reads.map(|reads| reads.setup.source.name.as_str()),
        view_proj: shot.view_proj,
        ambient: Vec3::ZERO,
        light: reads,
        vertices: Vertices::Shared,
        state,
    }
}

/// What a shader reads that finds the shadow term in `mask`, if there is one.
fn masked<'a>(reads: LightInputs<'a>, mask: Option<&'a ShadowResources>) -> LightInputs<'a> {
    match mask {
        None => reads,
        Some(_) => LightInputs {
            shadow: mask,
            masked: true,
            ..reads
        },
    }
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
        color: Some(ColorState {
            format,
            blend: additive.then_some(ADD),
            channels: wgpu::ColorWrites::ALL,
        }),
        depth: Some(DEPTH),
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

//! The camera's passes: one function a kind of picture.

use std::{collections::BTreeMap, time::Instant};

use glam::Vec3;
use half::slice::HalfFloatSliceExt as _;
use umbrage_wgpu::{ColorState, DrawState, ShadowResources};

use super::{
    Renderer, Shot,
    air::{self, LitAir},
    assets::Vertices,
    draw::{Command, record},
    frame::{FrameState, Lamp, LightInputs, PLANE, PassInputs, unfiltered},
    lights::{self, LightSetup, Term},
    passes::NamedPass,
    target::{DEPTH, Target},
};
use crate::{Decision, Path, Picture, RenderError, What};

impl Renderer {
    pub(super) fn shaded(
        &mut self,
        frame: &mut FrameState<'_>,
        shot: &Shot<'_>,
    ) -> Result<Picture, RenderError> {
        let target = self.target(frame, wgpu::TextureFormat::Rgba16Float)?;
        self.shade(frame, shot, &target)?;
        let bytes = self.finish(frame, &target)?;
        let halves: Vec<half::f16> = bytemuck::pod_collect_to_vec(&bytes);
        let mut floats = vec![0.0; halves.len()];
        halves.convert_to_f32_slice(&mut floats);
        let pixels = floats.as_chunks::<4>().0.iter();
        Ok(Picture::Shaded(
            pixels.map(|&[r, g, b, _]| [r, g, b]).collect(),
        ))
    }

    /// Records all passes of a shaded picture.
    pub(super) fn shade(
        &mut self,
        frame: &mut FrameState<'_>,
        shot: &Shot<'_>,
        target: &Target,
    ) -> Result<(), RenderError> {
        let format = target.format();
        let background = shot.scene.background.as_dvec3();
        let clear = wgpu::Color {
            r: background.x,
            g: background.y,
            b: background.z,
            a: 1.0,
        };
        let base = self.pass("base")?;
        let base = PassInputs {
            ambient: shot.scene.ambient,
            ..inputs(shot, base, Vec::new(), camera_state(format, base, &[]))
        };
        let visible = frame.objects.visible();
        let commands = self.prepare(frame, &base, &visible)?;
        self.run(frame, target, (base.pass, None), Some(clear), &commands);
        let illumination = self.pass("illumination")?;
        let (mut masks, mut lamps) = (None, Vec::new());
        for light in &shot.lights {
            let (lit, air) = (lit(frame, light), air::lit(shot, light));
            if lit.is_empty() && air.is_none() {
                continue;
            }
            let (to, is_airy) = ((target, false), air.is_some());
            let lamp = self.light_up(frame, shot, to, light, (&lit, air))?;
            if !lit.is_empty() && frame.options.path != Path::ForwardAll {
                let mask = self.mask(frame, shot, to, &mut masks, (lamp.reads(), &lit))?;
                let reads = masked(lamp.reads(), mask.as_ref());
                let state = camera_state(format, illumination, &[reads]);
                let inputs = inputs(shot, illumination, vec![reads], state);
                let commands = self.prepare(frame, &inputs, &lit)?;
                self.run(frame, target, (inputs.pass, inputs.cause), None, &commands);
            }
            lamps.push((lamp, lit, is_airy));
        }
        if frame.options.path == Path::ForwardAll {
            let lit = lamps.iter().map(|(lamp, lit, _)| (lamp, lit.as_slice()));
            self.add_all(frame, shot, target, &lit.collect::<Vec<_>>())?;
        }
        let airy = lamps.iter().filter(|(.., is_airy)| *is_airy);
        let airy: Vec<_> = airy.map(|(lamp, ..)| lamp).collect();
        self.add_air(frame, shot, target, &airy)
    }

    /// Adds the light of all `lamps` in one pass; with each come the objects that it reaches.
    fn add_all(
        &mut self,
        frame: &mut FrameState<'_>,
        shot: &Shot<'_>,
        target: &Target,
        lamps: &[(&Lamp<'_>, &[usize])],
    ) -> Result<(), RenderError> {
        let pass = self.pass("illumination")?;
        let mut reached: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (number, (_, lit)) in lamps.iter().enumerate() {
            for slot in *lit {
                reached.entry(*slot).or_default().push(number);
            }
        }
        let mut by_lamps: BTreeMap<Vec<usize>, Vec<usize>> = BTreeMap::new();
        for (slot, numbers) in reached {
            by_lamps.entry(numbers).or_default().push(slot);
        }
        let mut commands = Vec::new();
        for (numbers, slots) in by_lamps {
            let lights: Vec<_> = numbers.iter().map(|n| lamps[*n].0.reads()).collect();
            let to = (pass, target.format());
            commands.extend(self.prepare_lit(frame, shot, to, &lights, &slots)?);
        }
        if !commands.is_empty() {
            self.run(frame, target, (pass, None), None, &commands);
        }
        Ok(())
    }

    /// The commands that draw objects in `lights`: once, or, where that is more than a shader may read, by halves.
    fn prepare_lit<'a>(
        &mut self,
        frame: &mut FrameState<'_>,
        shot: &Shot<'_>,
        to: (NamedPass<'a>, wgpu::TextureFormat),
        lights: &[LightInputs<'a>],
        slots: &[usize],
    ) -> Result<Vec<Command>, RenderError> {
        let (pass, format) = to;
        let state = camera_state(format, pass, lights);
        let inputs = inputs(shot, pass, lights.to_vec(), state);
        match self.prepare(frame, &inputs, slots) {
            Err(error) if lights.len() > 1 && error.is_limit() => {
                let (first, rest) = lights.split_at(lights.len() / 2);
                let mut commands = self.prepare_lit(frame, shot, to, first, slots)?;
                commands.extend(self.prepare_lit(frame, shot, to, rest, slots)?);
                Ok(commands)
            }
            prepared => prepared,
        }
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

    /// Results of `pass` for each light and pixel; red's `clear` where nothing is seen.
    fn by_light(
        &mut self,
        frame: &mut FrameState<'_>,
        shot: &Shot<'_>,
        pass: &str,
        clear: wgpu::Color,
    ) -> Result<Vec<Vec<f32>>, RenderError> {
        let pass = self.pass(pass)?;
        let format = wgpu::TextureFormat::R32Float;
        let target = self.target(frame, format)?;
        let mut pictures = Vec::new();
        let mut masks = None;
        for light in &shot.lights {
            let lit = lit(frame, light);
            let (to, air) = ((&target, true), air::lit(shot, light));
            let lamp = self.light_up(frame, shot, to, light, (&lit, air))?;
            let reads = lamp.reads();
            // Fetches are counted of methods, and no mask is one.
            let mask = if frame.options.what == What::ShadowTerm {
                self.mask(frame, shot, (&target, true), &mut masks, (reads, &lit))?
            } else {
                None
            };
            let reads = masked(reads, mask.as_ref());
            let state = camera_state(format, pass, &[reads]);
            let mut commands =
                self.prepare(frame, &inputs(shot, pass, vec![reads], state), &lit)?;
            // Objects that the light does not reach hide what lies behind them, are shaded by nothing, and are drawn
            // for no light's sake.
            let seen = frame.objects.visible();
            let unlit = seen.iter().filter(|s| lit.binary_search(s).is_err());
            let unlit: Vec<_> = unlit.copied().collect();
            let state = camera_state(format, pass, &[]);
            commands.extend(self.prepare(frame, &inputs(shot, pass, Vec::new(), state), &unlit)?);
            let name = Some(light.source.name.as_str());
            self.run(frame, &target, (pass, name), Some(clear), &commands);
            pictures.push(self.finish_floats(frame, &target)?);
        }
        Ok(pictures)
    }

    /// For each light the texture fetches that its shafts take.
    pub(super) fn shaft_fetches(
        &mut self,
        frame: &mut FrameState<'_>,
        shot: &Shot<'_>,
    ) -> Result<Picture, RenderError> {
        let format = wgpu::TextureFormat::R32Float;
        let target = self.target(frame, format)?;
        // Surfaces seen, in no light: their depth is all that is read.
        let pass = self.pass("shadow_term")?;
        let seen = inputs(shot, pass, Vec::new(), camera_state(format, pass, &[]));
        let visible = frame.objects.visible();
        let commands = self.prepare(frame, &seen, &visible)?;
        self.run(
            frame,
            &target,
            (seen.pass, None),
            Some(wgpu::Color::WHITE),
            &commands,
        );
        let mut pictures = Vec::new();
        for light in &shot.lights {
            let Some(air) = air::lit(shot, light) else {
                let pixels = frame.options.width as usize * frame.options.height as usize;
                pictures.push(vec![0.0; pixels]);
                continue;
            };
            let lit = lit(frame, light);
            let lamp = self.light_up(frame, shot, (&target, false), light, (&lit, Some(air)))?;
            self.count_shafts(frame, shot, &target, &lamp)?;
            pictures.push(self.finish_floats(frame, &target)?);
        }
        Ok(Picture::Fetches(pictures))
    }

    pub(super) fn splits(
        &mut self,
        frame: &mut FrameState<'_>,
        shot: &Shot<'_>,
    ) -> Result<Picture, RenderError> {
        let shaded = self.shaded(frame, shot)?;
        let target = self.target(frame, PLANE)?;
        let pass = self.pass("linear_depth")?;
        let inputs = inputs(shot, pass, Vec::new(), camera_state(PLANE, pass, &[]));
        let visible = frame.objects.visible();
        let commands = self.prepare(frame, &inputs, &visible)?;
        let nothing = Some(wgpu::Color::TRANSPARENT);
        self.run(frame, &target, (inputs.pass, None), nothing, &commands);
        let bytes = self.finish(frame, &target)?;
        let pixels = bytes.as_chunks::<16>().0.iter();
        let depths: Vec<_> = pixels
            .map(|&[.., a, b, c, d]| f32::from_le_bytes([a, b, c, d]))
            .collect();
        let lights = (0..shot.lights.len()).map(|light| {
            let plan = frame.report.plans.get(light).and_then(Option::as_ref);
            let split = |depth: &f32| plan.and_then(|plan| plan.split_at(*depth));
            depths.iter().map(split).collect()
        });
        let splits = lights.collect();
        let Picture::Shaded(colors) = shaded else {
            return Ok(shaded);
        };
        Ok(Picture::Splits { colors, splits })
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
        let pass = self.pass("triangle")?;
        let inputs = PassInputs {
            vertices: Vertices::Own,
            ..inputs(shot, pass, Vec::new(), camera_state(format, pass, &[]))
        };
        let clear = wgpu::Color {
            r: NOTHING.into(),
            ..wgpu::Color::TRANSPARENT
        };
        let visible = frame.objects.visible();
        let commands = self.prepare(frame, &inputs, &visible)?;
        self.run(frame, &target, (inputs.pass, None), Some(clear), &commands);
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
        &mut self,
        frame: &FrameState<'_>,
        format: wgpu::TextureFormat,
    ) -> Result<Target, RenderError> {
        let size = [frame.options.width, frame.options.height];
        Target::new(&self.gpu, &mut self.targets, size, format)
    }

    /// A light as shaders read it: draws its shadow maps, where it has a method, for the objects at `lit` and the air.
    pub(super) fn light_up<'a>(
        &mut self,
        frame: &mut FrameState<'_>,
        shot: &Shot<'_>,
        to: (&Target, bool),
        light: &'a LightSetup<'a>,
        (lit, air): (&[usize], Option<LitAir>),
    ) -> Result<Lamp<'a>, RenderError> {
        let method = light.method.as_ref();
        let shadow = match method.filter(|_| !lit.is_empty() || air.is_some()) {
            Some(setup) => Some(self.cast(frame, shot, to, (light, setup), (lit, air.as_ref()))?),
            None => None,
        };
        Ok(Lamp {
            setup: light,
            constants: lights::constants(&light.source.light, shot.view.position),
            shadow,
        })
    }

    /// Records `pass`, drawn for a light where it names one.
    fn run(
        &self,
        frame: &mut FrameState<'_>,
        target: &Target,
        (pass, light): (NamedPass<'_>, Option<&str>),
        clear: Option<wgpu::Color>,
        commands: &[Command],
    ) {
        let mark = frame
            .timer
            .mark(&self.gpu, (pass.name, pass.purpose), light, false);
        record(
            &mut target.begin(&mut frame.encoder, clear, mark.as_ref()),
            commands,
        );
        frame.report.passes += 1;
    }

    /// Runs what was recorded, and reads the colours back.
    fn finish(&self, frame: &mut FrameState<'_>, target: &Target) -> Result<Vec<u8>, RenderError> {
        self.submit(frame)?;
        Ok(target.read(&self.gpu)?)
    }

    /// Runs what was recorded, to its end.
    pub(super) fn submit(&self, frame: &mut FrameState<'_>) -> Result<(), RenderError> {
        let started = Instant::now();
        let times = self.send(frame);
        self.gpu.wait()?;
        frame.report.gpu_milliseconds += 1e3 * started.elapsed().as_secs_f64();
        if let Some(times) = times {
            let times = frame.timer.read(&self.gpu, &times)?;
            frame.report.times.extend(times);
        }
        Ok(())
    }

    /// Submits what was recorded; the buffer that its times come to, where they are taken.
    pub(super) fn send(&self, frame: &mut FrameState<'_>) -> Option<wgpu::Buffer> {
        frame.objects.upload(&self.gpu);
        let next = self.gpu.device.create_command_encoder(&Default::default());
        let mut encoder = std::mem::replace(&mut frame.encoder, next);
        let times = frame.timer.resolve(&self.gpu, &mut encoder);
        self.gpu.queue.submit([encoder.finish()]);
        times
    }

    /// The same of a picture of single floats.
    pub(super) fn finish_floats(
        &self,
        frame: &mut FrameState<'_>,
        target: &Target,
    ) -> Result<Vec<f32>, RenderError> {
        let bytes = self.finish(frame, target)?;
        let pixels = bytes.as_chunks::<4>().0.iter().copied();
        Ok(pixels.map(f32::from_le_bytes).collect())
    }
}

/// Inputs of the camera's pass, for the `lights` that it reads.
fn inputs<'a>(
    shot: &Shot<'_>,
    pass: NamedPass<'a>,
    lights: Vec<LightInputs<'a>>,
    state: DrawState,
) -> PassInputs<'a> {
    PassInputs {
        pass,
        cause: match lights.as_slice() {
            [light] => Some(light.setup.source.name.as_str()),
            _ => None,
        },
        view_proj: shot.view_proj,
        ambient: Vec3::ZERO,
        lights,
        vertices: Vertices::Shared,
        state,
    }
}

/// The light's inputs for a shader that finds the shadow term in `mask`, if there is one.
fn masked<'a>(reads: LightInputs<'a>, mask: Option<&'a ShadowResources>) -> LightInputs<'a> {
    match mask {
        None => reads,
        Some(_) => LightInputs {
            shadow: mask,
            term: Term::Mask,
            ..reads
        },
    }
}

/// The slots of what may be seen and is reached by `light`.
fn lit(frame: &FrameState<'_>, light: &LightSetup<'_>) -> Vec<usize> {
    let light = &light.source.light;
    let reached = |slot: &usize| light.reaches(&frame.objects.at(*slot).bounds);
    frame
        .objects
        .visible()
        .iter()
        .copied()
        .filter(reached)
        .collect()
}

/// How the camera's passes draw: nearest wins, depth reversed, both sides of a triangle seen. A
/// pass that adds light meets the depth that the base pass left, computed alike.
fn camera_state(
    format: wgpu::TextureFormat,
    pass: NamedPass<'_>,
    lights: &[LightInputs<'_>],
) -> DrawState {
    DrawState {
        colors: vec![ColorState {
            format,
            blend: pass.blend,
            channels: wgpu::ColorWrites::ALL,
        }],
        depth: Some(DEPTH),
        compare: wgpu::CompareFunction::GreaterEqual,
        write_depth: pass.writes_depth,
        cull: None,
        front: wgpu::FrontFace::Ccw,
        unfiltered: unfiltered(lights),
    }
}

//! Scenes against configurations: the rows of a report.

use umbrage_compose::Stage;
use umbrage_isa::{Compiler, Isa, PipelineState};
use umbrage_render::{RenderError, Rendered, Scene};

use super::{
    Config, Lab, Progress, StudyError,
    drawn::Drawn,
    lab::{Subject, Unshadowed, mean},
    motion::{Moving, cameras, shimmer_of},
    timing::{Timing, time},
};
use crate::{
    report::{Pictures, Report, Row, SceneInfo, Skipped},
    truth::{Tracer, Truth, TruthStore},
};

/// Choices for a comparison, beyond scenes and configurations.
pub struct CompareOptions {
    /// Pixels across and down.
    pub size: (u32, u32),
    /// Pairs of pictures, one of the baseline and one of its own, that a configuration is timed by at the most; fewer than 7 give
    /// no interval, and times are not ranked.
    pub most_pairs: u32,
    /// Pictures, each way half as large, that shimmer is looked for in; fewer than 2 look for none.
    pub frames: u32,
    /// Where truths are kept from run to run.
    pub store: Option<TruthStore>,
    /// How a person would ask for the same report.
    pub command: String,
}

/// A report, and what to tell a person beside it.
pub struct Comparison {
    /// The report.
    pub report: Report,
    /// One for each row of the report.
    pub pictures: Vec<Pictures>,
    /// Damaged cache entries and the like.
    pub warnings: Vec<String>,
}

/// Draws each of `scenes` (a name and a scene) with each of `configs`, and measures error and cost.
///
/// `compiler` tells what a GPU would make of the shaders; without one, the report says why. A picture that a configuration
/// cannot draw (a light that its method cannot shadow, a map that the device
/// refuses) is listed in the report with the reason, and the rest goes on.
///
/// # Errors
/// Nothing to compare; two scenes of one name; a scene that cannot be traced, before any work is done.
pub fn compare(
    lab: &mut Lab,
    scenes: &[(String, Scene)],
    configs: &[Config],
    options: &CompareOptions,
    compiler: Result<Compiler, String>,
    progress: &dyn Progress,
) -> Result<Comparison, StudyError> {
    if scenes.is_empty() || configs.is_empty() {
        return Err(StudyError::Nothing);
    }
    for (index, (name, scene)) in scenes.iter().enumerate() {
        if scenes[..index].iter().any(|(other, _)| other == name) {
            return Err(StudyError::SameName { name: name.clone() });
        }
        Tracer::new(scene).map_err(|source| StudyError::Truth {
            scene: name.clone(),
            source,
        })?;
    }
    let mut compiler = compiler;
    let mut comparison = Comparison {
        report: Report {
            adapter: lab.adapter().to_owned(),
            command: options.command.clone(),
            width: options.size.0,
            height: options.size.1,
            most_pairs: options.most_pairs,
            isa_source: match &compiler {
                Ok(compiler) => compiler.family().to_owned(),
                Err(reason) => reason.clone(),
            },
            scenes: scenes
                .iter()
                .map(|(name, scene)| info(name, scene))
                .collect(),
            ..Report::default()
        },
        pictures: Vec::new(),
        warnings: Vec::new(),
    };
    for (name, scene) in scenes {
        let mut scene = scene.clone();
        // Shadows on surfaces are compared: air would hide them, and its maps would have more to hold.
        scene.medium = None;
        // The scene's own axes and settings are not the configuration's; only which lights cast is the scene's choice.
        for shadow in scene
            .lights
            .iter_mut()
            .filter_map(|light| light.shadow.as_mut())
        {
            shadow.axes.clear();
            shadow.settings.clear();
        }
        let mut run = Run {
            lab,
            name,
            scene: &scene,
            options,
            compiler: compiler.as_mut().ok(),
            progress,
            comparison: &mut comparison,
        };
        run.compare(configs)?;
    }
    comparison.report.mark_pareto();
    Ok(comparison)
}

fn half((width, height): (u32, u32)) -> (u32, u32) {
    (width.div_ceil(2), height.div_ceil(2))
}

fn info(name: &str, scene: &Scene) -> SceneInfo {
    let triangles = scene.objects.iter().map(|o| o.mesh.indices.len() / 3);
    SceneInfo {
        name: name.to_owned(),
        lights: scene.lights.len(),
        triangles: triangles.sum(),
        left_out: scene.left_out.clone(),
    }
}

/// One scene's turn.
struct Run<'a> {
    lab: &'a mut Lab,
    name: &'a str,
    scene: &'a Scene,
    options: &'a CompareOptions,
    compiler: Option<&'a mut Compiler>,
    progress: &'a dyn Progress,
    comparison: &'a mut Comparison,
}

impl Run<'_> {
    fn compare(&mut self, configs: &[Config]) -> Result<(), StudyError> {
        let truth = self.truth(self.scene, self.options.size)?;
        let moving = self.moving(&truth)?;
        let scene = self.scene;
        let subject = self.plain(|lab| lab.subject(scene, &truth))?;
        let unshadowed = self.plain(|lab| lab.unshadowed(&subject))?;
        let moving = self.plain(|lab| moving.subjects(lab))?;

        self.begin("drawing", configs.len());
        let (mut tried, mut entries) = (Vec::new(), Vec::new());
        for config in configs {
            match self.measure(&subject, &unshadowed, &moving, config)? {
                Ok(entry) => {
                    tried.push(config);
                    entries.push(entry);
                }
                Err(reason) => self.comparison.report.skipped.push(Skipped {
                    scene: self.name.to_owned(),
                    method: config.shadow.method.clone(),
                    config: config.name.clone(),
                    reason,
                }),
            }
            self.progress.step();
        }
        if tried.is_empty() {
            return Ok(());
        }
        self.begin("timing", tried.len());
        for ((row, pictures), config) in entries.into_iter().zip(tried) {
            let timing = self.time(&subject, config)?;
            self.comparison.report.rows.push(Row {
                casters_ms: timing.casters_ms,
                shading_ms: timing.shading_ms,
                frame_ms: timing.frame_ms,
                time_ratio: timing.ratio,
                time_pairs: timing.pairs,
                ..row
            });
            self.comparison.pictures.push(pictures);
            self.progress.step();
        }
        Ok(())
    }

    /// A configuration's errors and counts, its times left open; or why it cannot be drawn.
    fn measure(
        &mut self,
        subject: &Subject<'_>,
        unshadowed: &Unshadowed,
        moving: &[Subject<'_>],
        config: &Config,
    ) -> Result<Result<(Row, Pictures), String>, StudyError> {
        if let (_, Some(reason)) = self.lab.lights(self.scene, config)? {
            return Ok(Err(reason));
        }
        let options = config.options(subject.size());
        let drawn = self.lab.terms(subject, &options).and_then(|terms| {
            let fetches = self.lab.fetches(subject, &options)?;
            let decided = self.lab.decided(subject, config, mean(&fetches))?;
            let shaded = self.lab.render(subject.scene, &options)?;
            Ok((terms, fetches, decided, shaded))
        });
        // A device's refusal of one configuration says nothing of the others.
        let (terms, fetch_shares, decided, shaded) = match drawn {
            Ok(drawn) => drawn,
            Err(error) => return Ok(Err(error.to_string())),
        };
        let mut figures = subject.figures(&terms)?;
        let small = config.options(half(subject.size()));
        figures.shimmer = match shimmer_of(self.lab, moving, &small)? {
            Ok(shimmer) => shimmer,
            Err(error) => return Ok(Err(error.to_string())),
        };
        figures.flip = Some(subject.flip(unshadowed, &shaded)?);
        let report = &shaded.report;
        let drawn = Drawn::of(report);
        let row = Row {
            scene: self.name.to_owned(),
            method: config.shadow.method.clone(),
            config: config.name.clone(),
            path: config.path,
            figures,
            memory_bytes: report.shadow_bytes + report.mask_bytes,
            texels: report.texels,
            texels_written: drawn.texels,
            triangles: drawn.triangles,
            vertices: drawn.vertices,
            passes: report.caster_passes + report.derived_passes,
            draws: report.caster_draws,
            fetches_per_pixel: mean(&fetch_shares),
            fetch_shares,
            decided: decided.as_ref().map(|(decided, _)| *decided),
            isa: self.isa(&shaded)?,
            ..Row::default()
        };
        let mut pictures = subject.pictures(&terms, Some(&shaded))?;
        if let Some((_, decisions)) = decided {
            pictures = pictures.with_decisions(&decisions)?;
        }
        Ok(Ok((row, pictures)))
    }

    /// Figures of a GPU's compiler for the costliest fragment shader that lights the picture.
    fn isa(&mut self, shaded: &Rendered) -> Result<Option<Isa>, StudyError> {
        let Some(compiler) = self.compiler.as_deref_mut() else {
            return Ok(None);
        };
        let mut costliest: Option<Isa> = None;
        for permutation in self.lab.illumination(shaded)? {
            let state = PipelineState::of(&permutation);
            let stages = match compiler.cost(&permutation, &state) {
                Ok(stages) => stages,
                Err(error) => {
                    self.comparison.warnings.push(error.to_string());
                    continue;
                }
            };
            let fragment = stages
                .into_iter()
                .find(|cost| cost.stage == Stage::Fragment);
            let candidates = costliest.into_iter().chain(fragment.map(|cost| cost.isa));
            costliest = candidates.max_by_key(|isa| isa.inverse_throughput);
        }
        Ok(costliest)
    }

    fn time(&mut self, subject: &Subject<'_>, config: &Config) -> Result<Timing, StudyError> {
        let timed = time(self.lab, subject, config, self.options.most_pairs);
        timed.map_err(|(what, source)| StudyError::Render {
            scene: self.name.to_owned(),
            what,
            source,
        })
    }

    /// The pictures in which shimmer is looked for.
    fn moving(&mut self, truth: &Truth) -> Result<Moving, StudyError> {
        let frames = self.options.frames as usize;
        if frames < 2 {
            return Ok(Moving::default());
        }
        let size = half(self.options.size);
        let cameras = cameras(self.scene, &truth.sight, size.1, frames);
        let scene = self.scene;
        Moving::new(scene, &cameras, |scene| self.truth(scene, size))
    }

    fn truth(&mut self, scene: &Scene, size: (u32, u32)) -> Result<Truth, StudyError> {
        self.begin("tracing", Truth::rows(scene, size.1));
        let row = || self.progress.step();
        let traced = match &self.options.store {
            Some(store) => store.truth(scene, size, &[], &row),
            None => Truth::trace(scene, size, &[], &row).map(|truth| (truth, Vec::new())),
        };
        let (truth, warnings) = traced.map_err(|source| StudyError::Truth {
            scene: self.name.to_owned(),
            source,
        })?;
        self.comparison.warnings.extend(warnings);
        Ok(truth)
    }

    /// Draws for the scene's sake, not a configuration's.
    fn plain<T>(
        &mut self,
        draw: impl FnOnce(&mut Lab) -> Result<T, RenderError>,
    ) -> Result<T, StudyError> {
        draw(self.lab).map_err(|source| StudyError::Render {
            scene: self.name.to_owned(),
            what: "no shadow method".to_owned(),
            source,
        })
    }

    fn begin(&self, what: &str, steps: usize) {
        self.progress
            .begin(&format!("{}: {what}", self.name), steps);
    }
}

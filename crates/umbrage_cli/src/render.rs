//! `umbrage render`: a scene to a picture.

use std::{path::Path, process::ExitCode, sync::Arc};

use anyhow::{Context, Result, bail};
use serde::Serialize;
use umbrage::{
    compose::{Composer, Pack, Purpose, Source, Target, record},
    render::{
        self, Gpu, LeftOut, PermutationUse, RenderOptions, Rendered, Renderer, Scene, Shadow,
    },
};
use umbrage_measure::truth::TruthError;

use crate::{
    args::{RenderArgs, What},
    known::Known,
    output::{check_picture, print_json, waiting},
};

/// Output of `--json`.
#[derive(Serialize)]
struct Report<'a> {
    picture: &'a Path,
    adapter: &'a str,
    lights: Vec<UsedLight<'a>>,
    permutations: Permutations<'a>,
    /// Features of the models' files that the picture does not show.
    left_out: &'a [LeftOut],
    /// From the scene to the pixels in memory.
    milliseconds: f64,
}

/// A light of the picture.
#[derive(Serialize)]
struct UsedLight<'a> {
    /// Its place in the scene, from 0.
    index: usize,
    name: &'a str,
    /// Whether it casts shadows in this picture: of one that does not, the shadow term is 1.
    casts: bool,
}

#[derive(Serialize)]
struct Permutations<'a> {
    /// How many were linked for this picture.
    composed: usize,
    /// How many came from a cache.
    cached: usize,
    /// All of them, as they were first needed.
    used: Vec<Used<'a>>,
}

#[derive(Serialize)]
struct Used<'a> {
    key: String,
    /// Keys of the further lights that it is for.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    others: Vec<String>,
    from: &'static str,
    /// The object that first needed it.
    object: &'a str,
    /// The light that it was needed for, where one was: the light that the object lay in, or whose shadow
    /// it was drawn for.
    light: Option<&'a str>,
    /// Whether it draws casters, or a mask.
    #[serde(skip)]
    shadow: bool,
}

pub(crate) fn render(args: &RenderArgs, known: Known) -> Result<ExitCode> {
    check_picture(&args.out)?;
    let library = known.library(&[])?;
    let registry = known.registry;
    // The scene's own methods are checked light by light; this one is wrong in any scene.
    if let Some(method) = args.method.as_deref().filter(|method| *method != "none") {
        registry
            .methods
            .get(method)
            .context("--method: choose a known one, or `none` for no shadows")?;
    }
    let scene = args.staging.load(&args.scene)?;
    let (scene, lights) = choose_light(scene, args.light)?;
    check_left_open(args, &scene)?;
    let mut composer = Composer::new(library, Target::webgpu());
    if let Some(folder) = &args.cache {
        composer = composer.with_disk_cache(folder)?;
    }
    if let Some(pack) = &args.pack {
        composer = composer.with_pack(Arc::new(Pack::open(pack)?));
    }
    let composer = Arc::new(composer);
    let bar = waiting("rendering");
    let mut renderer = Renderer::new(Arc::new(Gpu::new()?), Arc::clone(&composer), registry);
    let rendered = renderer
        .render(&scene, &options(args))
        .with_context(|| format!("{} cannot be rendered", args.scene.display()))?;
    bar.finish_and_clear();
    rendered.save_png(&args.out)?;
    if let Some(record) = &args.record {
        record::append(record, &composer.composed())?;
    }
    for warning in &rendered.report.warnings {
        eprintln!("warning: {warning}");
    }
    let report = report(args, (&scene, &lights), &rendered);
    if args.json {
        print_json(&report)?;
    } else {
        tell(&report);
    }
    Ok(ExitCode::SUCCESS)
}

/// An error where the picture is of a shadow term that the scene leaves open: the truth would show another.
fn check_left_open(args: &RenderArgs, scene: &Scene) -> Result<()> {
    let of_term = matches!(
        args.what,
        What::ShadowTerm | What::Fetches | What::Decisions | What::Splits
    );
    let open = scene.lights.iter().all(|light| light.shadow.is_none());
    if of_term && open && args.method.is_none() && !scene.lights.is_empty() {
        bail!(
            "no light of {} says how it casts shadows, so there is no shadow term to show; \
             choose a method for all of them by --method, or `none`",
            args.scene.display()
        );
    }
    Ok(())
}

fn options(args: &RenderArgs) -> RenderOptions {
    RenderOptions {
        width: args.size.0,
        height: args.size.1,
        what: match args.what {
            What::Shaded => render::What::Shaded,
            What::ShadowTerm => render::What::ShadowTerm,
            What::Triangles => render::What::Triangles,
            What::Fetches => render::What::Fetches,
            What::Decisions => render::What::Decisions,
            What::ShaftFetches => render::What::ShaftFetches,
            What::Splits => render::What::Splits,
        },
        shadow: Shadow {
            method: args.method.clone().unwrap_or_default(),
            axes: args.axes.iter().cloned().collect(),
            settings: args.settings.iter().cloned().collect(),
        },
        path: args.path,
        shaft_steps: args.shaft_steps,
        ..RenderOptions::default()
    }
}

/// Leaves in the scene the light that is asked for, if one is; gives the places of its lights in the whole scene.
pub(crate) fn choose_light(scene: Scene, light: Option<usize>) -> Result<(Scene, Vec<usize>)> {
    let count = scene.lights.len();
    let Some(index) = light else {
        return Ok((scene, (0..count).collect()));
    };
    let lit = scene.lit_by(index);
    let lit = lit.ok_or(TruthError::NoSuchLight { index, count })?;
    Ok((lit, vec![index]))
}

fn report<'a>(
    args: &'a RenderArgs,
    (scene, lights): (&'a Scene, &[usize]),
    rendered: &'a Rendered,
) -> Report<'a> {
    let used = |used: &'a PermutationUse| Used {
        key: used.key.to_string(),
        others: used.others.iter().map(ToString::to_string).collect(),
        from: match used.source {
            Source::Linked => "linked",
            Source::Memory => "memory",
            Source::Disk => "disk",
            Source::Pack => "pack",
        },
        object: &used.object,
        light: used.light.as_deref(),
        shadow: matches!(used.purpose, Purpose::Maps | Purpose::Shadow),
    };
    Report {
        picture: &args.out,
        adapter: &rendered.adapter,
        lights: (lights.iter().zip(&scene.lights))
            .map(|(index, light)| UsedLight {
                index: *index,
                name: &light.name,
                casts: match args.method.as_deref() {
                    Some(Shadow::NONE) => false,
                    // A light without a `shadow` casts only where a method is given.
                    None if light.shadow.is_none() => false,
                    _ => scene.casts_shadow(light),
                },
            })
            .collect(),
        permutations: Permutations {
            composed: rendered.report.composed(),
            cached: rendered.report.cached(),
            used: rendered.report.permutations.iter().map(used).collect(),
        },
        left_out: &scene.left_out,
        milliseconds: rendered.report.milliseconds,
    }
}

/// The report for a person, on standard error.
fn tell(report: &Report<'_>) {
    for used in &report.permutations.used {
        let light = used
            .light
            .map(|light| match used.shadow {
                true => format!(" for the shadow of {light}"),
                false => format!(" in the light of {light}"),
            })
            .unwrap_or_default();
        let others: String = used.others.iter().map(|key| format!(" + {key}")).collect();
        let (from, key, object) = (used.from, &used.key, used.object);
        eprintln!("{from:6} {key}{others}: {object}{light}");
    }
    eprintln!(
        "{} was rendered on {} in {:.0} ms: {} permutations composed, {} from a cache",
        report.picture.display(),
        report.adapter,
        report.milliseconds,
        report.permutations.composed,
        report.permutations.cached,
    );
}

//! `umbrage compare`: methods against the truth, and what they cost.

use std::{path::Path, process::ExitCode, sync::Arc};

use anyhow::{Context, Result, bail};
use umbrage::{
    compose::{Composer, RonFile, Target},
    render::{Gpu, Scene},
    shadow::Registry,
};
use umbrage_isa::Compiler;
use umbrage_measure::{
    report::{Ratio, Report},
    study::{CompareOptions, Config, Lab, compare as measure},
    truth::TruthStore,
};

use crate::{
    args::CompareArgs,
    known::Known,
    output::Bars,
    report::{check_out, write_report},
};

pub(crate) fn compare(args: &CompareArgs, known: Known) -> Result<ExitCode> {
    check_out(&args.out)?;
    let library = known.library(&[])?;
    let registry = known.registry;
    let methods = chosen(args.methods.as_deref(), &registry)?;
    let scenes = load(args)?;
    let mut composer = Composer::new(library, Target::webgpu());
    if let Some(folder) = &args.cache {
        composer = composer.with_disk_cache(folder)?;
    }
    let mut lab = Lab::new(Arc::new(Gpu::new()?), Arc::new(composer), registry);
    let configs = configs(args, &lab, &methods)?;
    let options = CompareOptions {
        size: args.size,
        most_pairs: args.pairs,
        frames: args.frames,
        store: args.cache.as_ref().map(TruthStore::open).transpose()?,
        command: command_line(),
    };
    let compiler = Compiler::start(&args.family).map_err(|error| error.to_string());
    let bars = Bars::default();
    let measured = measure(&mut lab, &scenes, &configs, &options, compiler, &bars);
    bars.clear();
    let comparison = measured?;
    for warning in &comparison.warnings {
        eprintln!("warning: {warning}");
    }
    for skipped in &comparison.report.skipped {
        eprintln!(
            "skipped: {} with {} ({}): {}",
            skipped.scene, skipped.method, skipped.config, skipped.reason
        );
    }
    write_report(&comparison.report, &comparison.pictures, &args.out)?;
    tell(&comparison.report, &args.out);
    Ok(ExitCode::SUCCESS)
}

/// The methods named by `--methods`; all where it is missing or `all`.
pub(crate) fn chosen(asked: Option<&str>, registry: &Registry) -> Result<Vec<String>> {
    let Some(asked) = asked.filter(|asked| *asked != "all") else {
        return Ok(registry.methods.names().map(str::to_owned).collect());
    };
    let names: Vec<_> = asked
        .split(',')
        .map(|name| name.trim().to_owned())
        .collect();
    for name in &names {
        registry
            .methods
            .get(name)
            .context("--methods: name known ones with commas between, or `all`")?;
    }
    Ok(names)
}

/// The command as typed, without the way to this program.
fn command_line() -> String {
    let mut words = std::env::args();
    let program = words.next().unwrap_or_default();
    let program = Path::new(&program).file_stem();
    let program = program.map_or("umbrage".into(), |name| name.to_string_lossy().into_owned());
    let quoted = words.map(|word| match word.contains(char::is_whitespace) {
        true => format!("'{word}'"),
        false => word,
    });
    std::iter::once(program)
        .chain(quoted)
        .collect::<Vec<_>>()
        .join(" ")
}

/// The scenes, called by their files.
fn load(args: &CompareArgs) -> Result<Vec<(String, Scene)>> {
    let named = |path: &Path| {
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        Ok((name.into_owned(), args.staging.load(path)?))
    };
    args.scenes.iter().map(|path| named(path)).collect()
}

/// The configurations to try: of the methods asked for alone.
fn configs(args: &CompareArgs, lab: &Lab, methods: &[String]) -> Result<Vec<Config>> {
    let (registry, library) = (lab.registry(), lab.library());
    let standard = || Config::standard(methods, registry, library);
    if args.configs.is_empty() {
        return Ok(standard()?);
    }
    let mut all = Vec::<Config>::new();
    for path in &args.configs {
        let configs = match path.as_os_str() == "standard" {
            true => standard()?,
            false => Config::read(&RonFile::load(path)?, registry, library)?,
        };
        for config in configs {
            let same = |other: &&Config| {
                let id = |c: &Config| (c.shadow.method.clone(), c.name.clone(), c.path);
                id(other) == id(&config)
            };
            if let Some(Config { shadow, name, .. }) = all.iter().find(same) {
                let method = &shadow.method;
                bail!(
                    "--configs: method `{method}` has two configurations called `{name}`, one of {}; rename it",
                    path.display()
                );
            }
            all.push(config);
        }
    }
    all.retain(|config| methods.contains(&config.shadow.method));
    if all.is_empty() {
        bail!("--configs lists none of the methods that --methods names");
    }
    Ok(all)
}

/// Says for a person what there is to read.
fn tell(report: &Report, out: &Path) {
    let front = report.rows.iter().filter(|row| row.pareto);
    for row in front {
        eprintln!(
            "{}: {} ({}): {:.3} % wrong at {}, {} KiB",
            row.scene,
            row.method,
            row.config,
            100.0 * row.error(),
            time(&row.time_ratio),
            row.memory_bytes >> 10,
        );
    }
    eprintln!(
        "{} renderings are compared in {}",
        report.rows.len(),
        out.join("report.html").display()
    );
}

/// A time as the terminal shows it.
fn time(ratio: &Ratio) -> String {
    let Ratio {
        median, low, high, ..
    } = ratio;
    match ratio.is_told() {
        true => format!("{median:.2} of the time of one tap ({low:.2} to {high:.2})"),
        false => format!("a time too noisy to rank ({low:.2} to {high:.2})"),
    }
}

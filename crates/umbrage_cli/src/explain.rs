//! `umbrage explain`: what a key's permutation is made of and why, or which permutations an edit of a file touches.

use std::{
    collections::{BTreeMap, BTreeSet},
    fmt::Write,
    path::Path,
    process::ExitCode,
};

use anyhow::{Context, Result, bail};
use rayon::prelude::*;
use serde::Serialize;
use umbrage::compose::{Composer, Library, Selection, Target, Variant};

use crate::{
    args::ExplainArgs,
    known::Known,
    output::{print, print_json},
};

/// JSON report about a key.
#[derive(Serialize)]
struct OfKey {
    permutation: String,
    /// How many legal keys make it, at most 2^64 - 1.
    keys: u64,
    /// Each module, and why it is read.
    modules: Vec<(String, String)>,
    features: Vec<OfFeature>,
    bindings: Vec<OfBinding>,
}

#[derive(Serialize)]
struct OfFeature {
    name: String,
    /// The choices that set it; it is off where there are none.
    set_by: Vec<String>,
    asked_by: Vec<String>,
}

#[derive(Serialize)]
struct OfBinding {
    group: u32,
    binding: u32,
    name: String,
    module: String,
}

/// JSON report about a file.
#[derive(Serialize, Default)]
struct OfFile {
    module: String,
    /// How many permutations read it.
    permutations: usize,
    /// Of how many.
    of: usize,
    /// Values of each axis that these permutations' keys have, where they are not all.
    values: BTreeMap<String, BTreeSet<String>>,
}

pub(crate) fn explain(args: &ExplainArgs, known: &Known) -> Result<ExitCode> {
    let library = known.library(&args.packages)?;
    let path = Path::new(&args.what);
    if path.exists()
        || path
            .extension()
            .is_some_and(|extension| extension == "wesl")
    {
        let report = of_file(library, path)?;
        match args.json {
            true => print_json(&report)?,
            false => print(&report.text()?)?,
        }
    } else {
        let report = of_key(library, &args.what)
            .with_context(|| format!("`{}` cannot be explained", args.what))?;
        match args.json {
            true => print_json(&report)?,
            false => print(&report.text()?)?,
        }
    }
    Ok(ExitCode::SUCCESS)
}

fn of_key(library: Library, text: &str) -> Result<OfKey> {
    let composer = Composer::new(library, Target::webgpu());
    let key = composer.library().parse_key(text)?;
    let explanation = composer.explain(&key)?;
    let permutation = composer.compose(&key)?.permutation;
    let features = explanation.features.into_iter();
    let bindings = permutation.reflection.bindings.iter();
    Ok(OfKey {
        permutation: explanation.permutation.to_string(),
        keys: u64::try_from(explanation.keys).unwrap_or(u64::MAX),
        modules: (explanation.modules.into_iter())
            .map(|(module, reason)| (module, reason.to_string()))
            .collect(),
        features: features
            .map(|feature| OfFeature {
                name: feature.name,
                set_by: feature.set_by,
                asked_by: feature.asked_by,
            })
            .collect(),
        bindings: bindings
            .map(|binding| OfBinding {
                group: binding.group,
                binding: binding.binding,
                name: binding.name.clone(),
                module: binding.module.clone(),
            })
            .collect(),
    })
}

fn of_file(library: Library, path: &Path) -> Result<OfFile> {
    let Some(module) = library.module_of_file(path).map(str::to_owned) else {
        bail!(
            "{} is no module of these packages; name its package's folder with --package",
            path.display()
        );
    };
    let composer = Composer::new(library, Target::webgpu());
    let library = composer.library();
    let parts = composer
        .select(&Selection::all())
        .split(512)
        .into_par_iter();
    let reads = |variant: &Variant<'_>| variant.modules().any(|read| read == module);
    let parts = parts.map(|part| {
        let mut report = OfFile::default();
        for variant in part {
            report.of += 1;
            if reads(&variant) {
                report.permutations += 1;
                for axis in library.axes().iter() {
                    let own = report.values.entry(axis.name.clone()).or_default();
                    for value in axis.values() {
                        let number = library.value(&axis.name, value);
                        if number.is_some_and(|number| variant.may_have(number))
                            && !own.contains(value)
                        {
                            own.insert(value.to_owned());
                        }
                    }
                }
            }
        }
        report
    });
    let mut report = parts.reduce(OfFile::default, OfFile::and);
    report.values.retain(|axis, values| {
        let all = library.axes().get(axis);
        all.is_some_and(|axis| axis.values().count() > values.len())
    });
    Ok(OfFile { module, ..report })
}

impl OfKey {
    fn text(&self) -> Result<String, std::fmt::Error> {
        let mut text = String::new();
        writeln!(
            text,
            "permutation {}, of {} keys",
            self.permutation, self.keys
        )?;
        writeln!(text, "modules")?;
        for (module, reason) in &self.modules {
            writeln!(text, "  {module}: {reason}")?;
        }
        writeln!(text, "features")?;
        for feature in &self.features {
            let state = match feature.set_by.as_slice() {
                [] => "off".to_owned(),
                choices => format!("on by {}", choices.join(", ")),
            };
            writeln!(
                text,
                "  {}: {state}; asked for by {}",
                feature.name,
                feature.asked_by.join(", ")
            )?;
        }
        writeln!(text, "bindings")?;
        for binding in &self.bindings {
            let OfBinding {
                group,
                binding,
                name,
                module,
            } = binding;
            writeln!(
                text,
                "  @group({group}) @binding({binding}) {name} of {module}"
            )?;
        }
        Ok(text)
    }
}

impl OfFile {
    fn and(mut self, other: Self) -> Self {
        self.permutations += other.permutations;
        self.of += other.of;
        for (axis, values) in other.values {
            self.values.entry(axis).or_default().extend(values);
        }
        self
    }

    fn text(&self) -> Result<String, std::fmt::Error> {
        let mut text = String::new();
        let Self {
            module,
            permutations,
            of,
            values,
        } = self;
        writeln!(text, "{permutations} of {of} permutations read {module}")?;
        for (axis, values) in values {
            let values: Vec<_> = values.iter().cloned().collect();
            writeln!(text, "  {axis}: {}", values.join(", "))?;
        }
        Ok(text)
    }
}

//! The hard cases against their limits.

use std::collections::BTreeMap;

use rayon::prelude::*;
use serde::Serialize;
use umbrage_render::{RenderError, RenderOptions, Rendered, Scene};

use super::{
    Config, Lab, Progress, StudyError,
    lab::{Subject, terms},
    motion::{Moving, shimmer_between},
};
use crate::{
    cases::{Case, Limits, Verdict},
    figures::{Figures, bad_pixels},
    report::Pictures,
    truth::{Truth, TruthStore},
};

/// How a variant of a method did in a hard case.
#[derive(Clone, Debug, Serialize)]
pub struct CaseResult {
    /// The case's name.
    pub case: &'static str,
    /// The variant's name.
    pub variant: String,
    /// The method's name.
    pub method: String,
    /// How the figures stand against the limits.
    #[serde(flatten)]
    pub verdict: Verdict,
    /// The errors; of a motion those of its first picture, with the bad pixels of all.
    pub figures: Figures,
    /// Share of the samples that are on another side of ½ than in the case that this one must look the same
    /// as; none where there is no such case.
    pub differs: Option<f64>,
    /// Pictures of the first rendering.
    #[serde(skip)]
    pub pictures: Pictures,
}

/// Outcome of trying variants in hard cases.
#[derive(Clone, Debug, Default)]
pub struct Stressed {
    /// One result for each case and each variant that can be tried in it.
    pub results: Vec<CaseResult>,
    /// The variants whose method can shadow none of a case's lights, that choose otherwise than what makes
    /// the case, or that the table of limits does not try in it: case, variant and reason.
    pub skipped: Vec<(&'static str, String, String)>,
    /// Damaged cache entries.
    pub warnings: Vec<String>,
}

/// Draws each of `cases` with each of `variants` ([`Limits::variants_of`]), and holds the errors against `limits` by
/// the variants' names. A case that must look like another wants that one among `cases`, before it. Of a case's
/// lights those are measured that the method can shadow.
///
/// # Errors
/// A method that is not registered, and what cannot be traced or rendered.
pub fn stress(
    lab: &mut Lab,
    variants: &[Config],
    cases: &[Case],
    limits: &Limits,
    store: Option<&TruthStore>,
    progress: &dyn Progress,
) -> Result<Stressed, StudyError> {
    let mut run = Run {
        lab,
        limits,
        store,
        progress,
        twins: BTreeMap::new(),
        stressed: Stressed::default(),
    };
    progress.begin("hard cases", cases.len() * variants.len());
    for case in cases {
        let is_twin = cases.iter().any(|other| other.same_as == Some(case.name));
        run.case(case, variants, is_twin)?;
    }
    Ok(run.stressed)
}

/// All cases' turns.
struct Run<'a> {
    lab: &'a mut Lab,
    limits: &'a Limits,
    store: Option<&'a TruthStore>,
    progress: &'a dyn Progress,
    /// Renderings of the cases that others must look like, by case and variant.
    twins: BTreeMap<(&'static str, &'a str), Vec<Rendered>>,
    stressed: Stressed,
}

impl<'a> Run<'a> {
    fn case(
        &mut self,
        case: &Case,
        variants: &'a [Config],
        is_twin: bool,
    ) -> Result<(), StudyError> {
        let moving = Moving::new(&case.scene, case.cameras(), |scene| {
            let (truth, warnings) = truth(scene, case, self.store)?;
            self.stressed.warnings.extend(warnings);
            Ok(truth)
        })?;
        // Truth that methods which shadow the same lights are held against is found once.
        let mut tries = BTreeMap::<_, Vec<_>>::new();
        for variant in variants {
            let fit = match self.limits.passes_over(case.name, &variant.name) {
                Some(reason) => Err(reason.to_owned()),
                None => Try::new(self.lab, case, variant)?,
            };
            match fit {
                Ok((lights, fit)) => tries.entry(lights).or_default().push(fit),
                Err(reason) => {
                    let name = variant.name.clone();
                    self.stressed.skipped.push((case.name, name, reason));
                    self.progress.step();
                }
            }
        }
        let mut results = Vec::new();
        for (lights, tries) in &tries {
            results.extend(self.lit(case, &moving.lit_by(lights), tries, is_twin)?);
        }
        results.sort_by_key(|result| variants.iter().position(|v| v.name == result.variant));
        self.stressed.results.extend(results);
        Ok(())
    }

    /// Variants whose methods shadow the same lights, in these alone.
    fn lit(
        &mut self,
        case: &Case,
        moving: &Moving,
        tries: &[Try<'a>],
        is_twin: bool,
    ) -> Result<Vec<CaseResult>, StudyError> {
        let subjects = moving.subjects(self.lab);
        let subjects = subjects.map_err(|source| refused(case, "no shadow method", source))?;
        let drawn = tries.iter().map(|fit| {
            self.progress.step();
            fit.draw(self.lab, case, &subjects)
        });
        let drawn = drawn.collect::<Result<Vec<_>, _>>()?;
        // The device waits meanwhile, but the cores share the variants.
        let results = tries.par_iter().zip(&drawn).map(|(fit, drawn)| {
            let twin = (case.same_as)
                .and_then(|twin| self.twins.get(&(twin, fit.variant.name.as_str())))
                .map(|twin| differs(&subjects, drawn, twin));
            fit.judge(case, &subjects, drawn, twin, self.limits)
        });
        let results = results.collect::<Result<Vec<_>, _>>()?;
        if is_twin {
            let names = tries
                .iter()
                .map(|fit| (case.name, fit.variant.name.as_str()));
            self.twins.extend(names.zip(drawn));
        }
        Ok(results)
    }
}

fn truth(
    scene: &Scene,
    case: &Case,
    store: Option<&TruthStore>,
) -> Result<(Truth, Vec<String>), StudyError> {
    let traced = match store {
        Some(store) => store.truth(scene, case.size, &[], &|| ()),
        None => Truth::trace(scene, case.size, &[], &|| ()).map(|truth| (truth, Vec::new())),
    };
    traced.map_err(|source| StudyError::Truth {
        scene: case.name.to_owned(),
        source,
    })
}

fn refused(case: &Case, what: &str, source: RenderError) -> StudyError {
    StudyError::Render {
        scene: case.name.to_owned(),
        what: what.to_owned(),
        source,
    }
}

/// A variant that is tried in a case.
struct Try<'a> {
    variant: &'a Config,
    options: RenderOptions,
}

impl<'a> Try<'a> {
    /// Variant to try, and in which of the case's lights, by their places; or why it is not tried.
    fn new(
        lab: &Lab,
        case: &Case,
        variant: &'a Config,
    ) -> Result<Result<(Vec<usize>, Self), String>, StudyError> {
        let (lights, refusal) = lab.lights(&case.scene, variant)?;
        if let Some(reason) = refusal.filter(|_| lights.is_empty()) {
            return Ok(Err(reason));
        }
        let choice = variant.shadow.choice(lab.registry(), lab.library())?;
        let options = case.options(variant, &choice);
        Ok(options.map(|options| (lights, Self { variant, options })))
    }

    /// The shadow terms of each subject.
    fn draw(
        &self,
        lab: &mut Lab,
        case: &Case,
        subjects: &[Subject<'_>],
    ) -> Result<Vec<Rendered>, StudyError> {
        let drawn = subjects.iter().map(|subject| {
            let terms = lab.terms(subject, &self.options);
            terms.map_err(|source| refused(case, &self.variant.name, source))
        });
        drawn.collect()
    }

    /// Holds renderings of a case (one picture for each subject) against its limits.
    fn judge(
        &self,
        case: &Case,
        subjects: &[Subject<'_>],
        drawn: &[Rendered],
        differs: Option<f64>,
        limits: &Limits,
    ) -> Result<CaseResult, StudyError> {
        let no_limits = || StudyError::NoLimits { case: case.name };
        let first = subjects.first().zip(drawn.first());
        let (subject, rendered) = first.ok_or_else(no_limits)?;
        let terms = drawn.iter().flat_map(terms);
        let figures = Figures {
            bad_pixels: terms.map(|terms| bad_pixels(terms)).sum(),
            shimmer: shimmer_between(subjects, drawn)?,
            ..subject.figures(rendered)?
        };
        let name = &self.variant.name;
        let verdict = limits.judge(case.name, name, &figures, differs);
        Ok(CaseResult {
            case: case.name,
            variant: name.clone(),
            method: self.variant.shadow.method.clone(),
            verdict: verdict.ok_or_else(no_limits)?,
            figures,
            differs,
            pictures: subject.pictures(rendered, None)?,
        })
    }
}

/// Share of the compared samples that are on another side of ½ than in `twin`, the same pictures drawn
/// elsewhere or in another size.
fn differs(subjects: &[Subject<'_>], rendered: &[Rendered], twin: &[Rendered]) -> f64 {
    let (mut compared, mut different) = (0_u64, 0_u64);
    for ((subject, own), twin) in subjects.iter().zip(rendered).zip(twin) {
        let lights = subject.truth.terms.iter().zip(terms(own)).zip(terms(twin));
        for ((truth, own), twin) in lights {
            let samples = truth.iter().zip(own.iter().zip(twin)).enumerate();
            for (_, (_, (own, twin))) in
                samples.filter(|(pixel, (term, _))| term.is_some() && subject.agrees(*pixel))
            {
                compared += 1;
                different += u64::from((*own > 0.5) != (*twin > 0.5));
            }
        }
    }
    different as f64 / compared.max(1) as f64
}

//! The hard cases against their limits.

use std::collections::BTreeMap;

use serde::Serialize;
use umbrage_render::{RenderError, Rendered, Scene, What};

use super::{
    Lab, Progress, StudyError,
    lab::{Subject, terms},
    motion::{Moving, shimmer_between},
};
use crate::{
    cases::{Case, Limits, Verdict},
    figures::Figures,
    report::Pictures,
    truth::{Truth, TruthStore},
};

/// How a method did in a hard case.
#[derive(Clone, Debug, Serialize)]
pub struct CaseResult {
    /// The case's name.
    pub case: &'static str,
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
    /// What the first picture looks like.
    #[serde(skip)]
    pub pictures: Pictures,
}

/// What came of trying methods in hard cases.
#[derive(Clone, Debug, Default)]
pub struct Stressed {
    /// One result for each case and each method that can shadow one of its lights.
    pub results: Vec<CaseResult>,
    /// The methods that can shadow none of a case's lights: case, method and reason.
    pub skipped: Vec<(&'static str, String, String)>,
    /// Damaged cache entries.
    pub warnings: Vec<String>,
}

/// Draws each of `cases` with each of `methods`, and holds the errors against `limits`. A case that must look
/// like another wants that one among `cases`, before it. Of a case's lights those are measured that the method can
/// shadow.
///
/// # Errors
/// A method that is not registered, and what cannot be traced or rendered.
pub fn stress(
    lab: &mut Lab,
    methods: &[String],
    cases: &[Case],
    limits: &Limits,
    store: Option<&TruthStore>,
    progress: &dyn Progress,
) -> Result<Stressed, StudyError> {
    let mut stressed = Stressed::default();
    let mut drawn: BTreeMap<(&str, String), Vec<Rendered>> = BTreeMap::new();
    progress.begin("hard cases", cases.len() * methods.len());
    for case in cases {
        let moving = Moving::new(&case.scene, case.cameras(), |scene| {
            let (truth, warnings) = truth(scene, case, store)?;
            stressed.warnings.extend(warnings);
            Ok(truth)
        })?;
        let render = |what: &str| {
            let (scene, what) = (case.name.to_owned(), what.to_owned());
            move |source: RenderError| StudyError::Render {
                scene,
                what,
                source,
            }
        };
        for name in methods {
            progress.step();
            let (lights, refusal) = lab.lights(&case.scene, name)?;
            if let Some(reason) = refusal.filter(|_| lights.is_empty()) {
                stressed.skipped.push((case.name, name.clone(), reason));
                continue;
            }
            let moving = moving.lit_by(&lights);
            let subjects = moving.subjects(lab).map_err(render(name))?;
            let method = lab.registry().get(name).map_err(StudyError::Method)?;
            let options = case.options(method.as_ref(), What::ShadowTerm);
            let rendered = subjects.iter().map(|subject| lab.terms(subject, &options));
            let rendered = rendered
                .collect::<Result<Vec<_>, _>>()
                .map_err(render(name))?;
            let twin = case
                .same_as
                .and_then(|twin| drawn.get(&(twin, name.clone())));
            let differs = twin.map(|twin| differs(&subjects, &rendered, twin));
            let result = judge(case, name, &subjects, &rendered, differs, limits)?;
            stressed.results.push(result);
            drawn.insert((case.name, name.clone()), rendered);
        }
    }
    Ok(stressed)
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

/// What was rendered of a case (one picture for each subject) against its limits.
fn judge(
    case: &Case,
    method: &str,
    subjects: &[Subject<'_>],
    rendered: &[Rendered],
    differs: Option<f64>,
    limits: &Limits,
) -> Result<CaseResult, StudyError> {
    let pairs = || subjects.iter().zip(rendered);
    let each = pairs().map(|(subject, rendered)| subject.figures(rendered));
    let each = each.collect::<Result<Vec<_>, _>>()?;
    let first = each.first().cloned().unwrap_or_default();
    let figures = Figures {
        bad_pixels: each.iter().map(|figures| figures.bad_pixels).sum(),
        shimmer: shimmer_between(subjects, rendered)?,
        ..first
    };
    let no_limits = || StudyError::NoLimits { case: case.name };
    let verdict = limits
        .judge(case.name, method, &figures, differs)
        .ok_or_else(no_limits)?;
    let pictures = pairs()
        .next()
        .map(|(subject, rendered)| subject.pictures(rendered, None));
    Ok(CaseResult {
        case: case.name,
        method: method.to_owned(),
        verdict,
        figures,
        differs,
        pictures: pictures.ok_or_else(no_limits)??,
    })
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

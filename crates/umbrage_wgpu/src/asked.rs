//! Lights as they were asked for, so that nothing is planned again that stands as it was planned.

use std::sync::Arc;

use umbrage_compose::{Composed, Source};
use umbrage_shadow::{Aabb, Answers, Constants, Light, ShadowPlan, View};

use crate::{CheckedShadow, Executed, Identity, Job, Run, ShadowResources};

/// All that a light's plan follows from, and what came of it.
pub(crate) struct Asked {
    shadow: CheckedShadow,
    view: View,
    light: Light,
    casters: Vec<Aabb>,
    receivers: Vec<Aabb>,
    air: Option<Aabb>,
    answers: Answers,
    identities: Vec<Identity>,
    choices: Vec<(String, String)>,
    constants: Constants,
    depth_size: Option<[u32; 2]>,
    /// The revision of the camera's depth, where passes read it.
    depth: Option<u64>,
    outcome: Outcome,
}

/// A plan that was executed.
pub(crate) struct Outcome {
    pub(crate) plan: Arc<ShadowPlan>,
    pub(crate) resources: Arc<ShadowResources>,
    /// The shaders of passes that draw no caster.
    pub(crate) composed: Vec<(String, Composed)>,
    /// The revision of the camera's depth, where passes read it.
    pub(crate) depth: Option<u64>,
}

impl Asked {
    /// A job and its outcome; `before` lends its memory.
    pub(crate) fn new(job: &Job<'_>, mut outcome: Outcome, before: Option<Self>) -> Self {
        let frame = job.frame;
        let (mut casters, mut receivers, mut identities) = match before {
            Some(before) => (before.casters, before.receivers, before.identities),
            None => Default::default(),
        };
        frame.casters.casters.clone_into(&mut casters);
        frame.casters.receivers.clone_into(&mut receivers);
        job.casters.clone_into(&mut identities);
        let choices = job.choices.iter();
        let choices = choices.map(|(axis, value)| ((*axis).to_owned(), (*value).to_owned()));
        for (_, composed) in &mut outcome.composed {
            composed.source = Source::Memory;
            composed.warnings.clear();
        }
        Self {
            shadow: job.shadow.clone(),
            view: frame.view.clone(),
            light: frame.light.clone(),
            casters,
            receivers,
            air: frame.casters.air,
            answers: frame.answers.clone(),
            identities,
            choices: choices.collect(),
            constants: job.constants.clone(),
            depth_size: frame.camera_depth,
            depth: outcome.depth,
            outcome,
        }
    }

    /// Whether `job` asks for the same.
    fn is(&self, job: &Job<'_>) -> bool {
        let frame = job.frame;
        let mut choices = self.choices.iter().zip(job.choices);
        // Cheap comparisons come first.
        self.view == *frame.view
            && self.light == *frame.light
            && self.air == frame.casters.air
            && self.depth_size == frame.camera_depth
            && (self.depth.is_none() || self.depth == job.camera_depth.map(|depth| depth.revision))
            && self.shadow.is(job.shadow)
            && self.shadow.settings == *frame.settings
            && self.shadow.axes == *frame.axes
            && self.answers == *frame.answers
            && self.constants == *job.constants
            && self.choices.len() == job.choices.len()
            && choices.all(|((a, v), (axis, value))| a == axis && v == value)
            && self.identities == job.casters
            && self.casters == frame.casters.casters
            && self.receivers == frame.casters.receivers
    }

    /// The outcome again, where `job` asks for the same.
    pub(crate) fn again(&self, job: &Job<'_>) -> Option<(Executed, &[(String, Composed)])> {
        self.is(job).then(|| {
            let executed = Executed {
                resources: Arc::clone(&self.outcome.resources),
                plan: Arc::clone(&self.outcome.plan),
                runs: vec![Run::Kept; self.outcome.plan.passes.len()],
                question: None,
            };
            (executed, self.outcome.composed.as_slice())
        })
    }
}

//! Plans, as their parts make them, checked by themselves: before anything is made or recorded for them.

use std::{
    any::Any,
    collections::BTreeSet,
    panic::{AssertUnwindSafe, catch_unwind},
};

use umbrage_shadow::{
    BufferContents, BufferDesc, MAX_QUESTIONS, MAX_REGIONS, Part, Pass, Reads, Region, ShadowPlan,
};

use crate::{Error, Job};

/// The plan of the job's parts, for a device with these features.
pub(crate) fn plan(job: &Job<'_>, there: wgpu::Features) -> Result<ShadowPlan, Error> {
    let plan = planned(job)?;
    check_numbers(job, &plan)?;
    check_regions(job, &plan.regions)?;
    check_question(job, &plan)?;
    check_names(job, &plan)?;
    check_needs(job, &plan, there)?;
    Ok(plan)
}

/// The plan of the job's parts. They are anybody's: one that panics is no reason for the engine to end.
fn planned(job: &Job<'_>) -> Result<ShadowPlan, Error> {
    let method = job.shadow.method();
    // A part has no state to be left broken.
    let planned = catch_unwind(AssertUnwindSafe(|| method.plan(job.frame)));
    let light = job.name.to_owned();
    let planned = planned.map_err(|panic| {
        let mut parts = format!("method `{}`", method.name());
        for (kind, part) in [
            ("depths", job.frame.depth.map(Part::name)),
            ("filter", job.frame.filter.map(Part::name)),
        ] {
            parts.extend(part.map(|part| format!(" with {kind} `{part}`")));
        }
        Error::Panicked {
            light: light.clone(),
            parts,
            said: said(&*panic).to_owned(),
        }
    })?;
    planned.map_err(|source| Error::Plan { light, source })
}

/// A panic's words.
pub(crate) fn said(panic: &(dyn Any + Send)) -> &str {
    let said = panic.downcast_ref::<String>().map(String::as_str);
    let said = said.or_else(|| panic.downcast_ref::<&str>().copied());
    said.unwrap_or("no words")
}

/// Whether what a plan tells of its filter and its reach are numbers.
fn check_numbers(job: &Job<'_>, plan: &ShadowPlan) -> Result<(), Error> {
    let (radius, distance) = (plan.filter_radius, plan.shadow_distance);
    let problem = if !(radius >= 0.0 && radius.is_finite()) {
        format!("a filter's radius of {radius} texels")
    } else if let Some(distance) = distance.filter(|distance| distance.is_nan()) {
        format!("a shadow distance of {distance} m")
    } else {
        return Ok(());
    };
    Err(bad_plan(job, &problem))
}

/// Whether regions of view depth follow each other, with axes of the chosen parts.
fn check_regions(job: &Job<'_>, regions: &[Region]) -> Result<(), Error> {
    if regions.len() > MAX_REGIONS {
        let problem = format!(
            "{} regions of view depth: {MAX_REGIONS} at the most",
            regions.len()
        );
        return Err(bad_plan(job, &problem));
    }
    let mut start = 0.0;
    for Region { end, axes } in regions {
        // NaN is not beyond.
        if !(*end > start && end.is_finite()) {
            let problem = format!("a region of view depth from {start} m to {end} m");
            return Err(bad_plan(job, &problem));
        }
        let known = job.shadow.choice.axes();
        if let Some(axis) = axes.keys().find(|axis| !known.contains(&axis.as_str())) {
            let problem = format!("a region with the axis `{axis}`, which is none of its axes");
            return Err(bad_plan(job, &problem));
        }
        start = *end;
    }
    Ok(())
}

/// Whether what a plan asks about are buffers that its passes write, and whether it asks too often.
fn check_question(job: &Job<'_>, plan: &ShadowPlan) -> Result<(), Error> {
    let Some(first) = plan.asks.first() else {
        return Ok(());
    };
    let written = |name: &String| {
        let mut passes = plan.passes.iter().flat_map(Pass::writes);
        let holds = |desc: &BufferDesc| {
            desc.name == *name && matches!(desc.contents, BufferContents::Written(_))
        };
        plan.buffers.iter().any(holds) && passes.any(|written| written == name)
    };
    let problem = if let Some(name) = plan.asks.iter().find(|name| !written(name)) {
        format!("a question about `{name}`, which is no buffer that its passes write")
    } else if job.frame.answers.questions() >= MAX_QUESTIONS {
        format!(
            "one more question, about `{first}`, where {MAX_QUESTIONS} were answered: so many may follow each other"
        )
    } else {
        return Ok(());
    };
    Err(bad_plan(job, &problem))
}

/// Whether each of the plan's textures and buffers has a name of its own.
fn check_names(job: &Job<'_>, plan: &ShadowPlan) -> Result<(), Error> {
    let textures = plan.textures.iter().map(|desc| &desc.name);
    let buffers = plan.buffers.iter().map(|desc| &desc.name);
    let mut known = BTreeSet::from([Reads::CAMERA_DEPTH]);
    match textures.chain(buffers).find(|name| !known.insert(name)) {
        Some(name) => {
            let problem = format!(
                "two textures or buffers `{name}` (`{}` is the camera's)",
                Reads::CAMERA_DEPTH
            );
            Err(bad_plan(job, &problem))
        }
        None => Ok(()),
    }
}

/// Whether the device has what the plan needs.
fn check_needs(job: &Job<'_>, plan: &ShadowPlan, there: wgpu::Features) -> Result<(), Error> {
    let mut needs = plan.needs.iter();
    let Some(need) = needs.find(|need| !there.contains(need.features)) else {
        return Ok(());
    };
    let missing = (need.features - there).iter_names();
    let missing: Vec<_> = missing
        .map(|(name, _)| name.to_lowercase().replace('_', "-"))
        .collect();
    Err(Error::Missing {
        light: job.name.to_owned(),
        method: job.shadow.method().name().to_owned(),
        features: missing.join(", "),
        instead: need.instead.clone(),
    })
}

/// Whether the engine gives the camera's depth that a pass reads, as large as it says.
pub(crate) fn camera_depth(job: &Job<'_>, pass: &Pass) -> Result<(), Error> {
    let light = job.name.to_owned();
    let Some(depth) = &job.camera_depth else {
        return Err(Error::NoDepth {
            light,
            method: job.shadow.method().name().to_owned(),
            pass: pass.shader().to_owned(),
        });
    };
    let texture = depth.view.texture();
    let (size, told) = ([texture.width(), texture.height()], job.frame.camera_depth);
    let problem = if !texture.format().has_depth_aspect() {
        format!("is of {:?}: give a view of depth", texture.format())
    } else if texture.sample_count() > 1 {
        "has several samples a texel: resolve it first".to_owned()
    } else if told != Some(size) {
        format!(
            "is {} by {} texels, and the frame tells of {told:?}: have it tell that (`Frame::camera_depth`)",
            size[0], size[1]
        )
    } else {
        return Ok(());
    };
    Err(Error::BadDepth { light, problem })
}

/// A fault of the method's.
pub(crate) fn bad_plan(job: &Job<'_>, problem: &str) -> Error {
    Error::BadPlan {
        light: job.name.to_owned(),
        method: job.shadow.method().name().to_owned(),
        problem: problem.to_owned(),
    }
}

//! `umbrage truth`: a scene's shadow term by rays.

use std::{path::Path, process::ExitCode, time::Instant};

use anyhow::{Context, Result};
use glam::DVec3;
use indicatif::ProgressBar;
use serde::Serialize;
use umbrage::{
    render::{Picture, Scene},
    shadow::{Light, LightKind},
};
use umbrage_measure::truth::{Source, Tracer, TruthError};

use crate::{
    args::TruthArgs,
    output::{check_picture, print_json, progress},
};

/// What `--json` prints: all that a tracer of another make needs beside the scene's triangles.
#[derive(Serialize)]
struct Report<'a> {
    picture: &'a Path,
    camera: Camera,
    /// The lights whose shadows the picture shows.
    lights: Vec<ReportLight<'a>>,
    triangles: usize,
    /// From the scene to the pixels in memory.
    milliseconds: f64,
}

/// World space: metres, right-handed, y up.
#[derive(Serialize)]
struct Camera {
    position: [f64; 3],
    /// Unit quaternion x, y, z, w from the camera's axes to the world's; it looks along −z of its own.
    rotation: [f64; 4],
    forward: [f64; 3],
    up: [f64; 3],
    /// Full vertical angle, radians.
    fov_y: f64,
    near: f64,
    far: f64,
    width: u32,
    height: u32,
}

#[derive(Serialize)]
struct ReportLight<'a> {
    /// Its place in the scene, from 0.
    index: usize,
    name: &'a str,
    kind: &'static str,
    position: Option<[f64; 3]>,
    /// Unit, away from the light.
    direction: Option<[f64; 3]>,
    /// Angles from the axis, radians.
    inner_angle: Option<f64>,
    outer_angle: Option<f64>,
    /// Metres; no light beyond.
    range: Option<f64>,
}

pub(crate) fn truth(args: &TruthArgs) -> Result<ExitCode> {
    check_picture(&args.out)?;
    let scene = Scene::load(&args.scene)?;
    let lights = match args.light {
        Some(light) => vec![light],
        None => (0..scene.lights.len()).collect(),
    };
    let (width, height) = args.size;
    // One turn of the rows to see, and one for each light.
    let bar = progress("tracing", height as usize * (1 + lights.len()));
    let start = Instant::now();
    let traced = trace(&scene, args.size, &lights, &bar)
        .with_context(|| format!("{} cannot be traced", args.scene.display()));
    let milliseconds = start.elapsed().as_secs_f64() * 1e3;
    bar.finish_and_clear();
    let (triangles, picture) = traced?;
    picture.save_png(width, height, &args.out)?;
    let report = Report {
        picture: &args.out,
        camera: camera(&scene, args.size),
        lights: lights
            .iter()
            .filter_map(|index| Some((*index, scene.lights.get(*index)?)))
            .map(|(index, light)| report_light(index, &light.name, &light.light))
            .collect(),
        triangles,
        milliseconds,
    };
    if args.json {
        print_json(&report)?;
    } else {
        eprintln!(
            "{}: {} triangles and {} lights were traced in {:.0} ms",
            args.out.display(),
            report.triangles,
            report.lights.len(),
            report.milliseconds,
        );
    }
    Ok(ExitCode::SUCCESS)
}

fn trace(
    scene: &Scene,
    (width, height): (u32, u32),
    lights: &[usize],
    bar: &ProgressBar,
) -> Result<(usize, Picture), TruthError> {
    let tracer = Tracer::new(scene)?;
    let row = || bar.inc(1);
    let sight = tracer.look(width, height, &row)?;
    let terms = lights.iter().map(|light| {
        let terms = tracer.shadow(&sight, *light, Source::Sharp, &row)?;
        Ok(terms.into_iter().map(|term| term.unwrap_or(1.0)).collect())
    });
    let terms = terms.collect::<Result<_, TruthError>>()?;
    Ok((tracer.triangles(), Picture::ShadowTerm(terms)))
}

fn camera(scene: &Scene, (width, height): (u32, u32)) -> Camera {
    let camera = &scene.camera;
    let rotation = camera.rotation.normalize();
    Camera {
        position: camera.position.to_array(),
        rotation: rotation.to_array(),
        forward: (rotation * DVec3::NEG_Z).to_array(),
        up: (rotation * DVec3::Y).to_array(),
        fov_y: camera.fov_y,
        near: camera.near,
        far: camera.far,
        width,
        height,
    }
}

fn report_light<'a>(index: usize, name: &'a str, light: &Light) -> ReportLight<'a> {
    let bare = ReportLight {
        index,
        name,
        kind: "directional",
        position: None,
        direction: None,
        inner_angle: None,
        outer_angle: None,
        range: None,
    };
    match light.kind {
        LightKind::Directional { direction } => ReportLight {
            direction: Some(direction.to_array()),
            ..bare
        },
        LightKind::Spot {
            position,
            direction,
            inner_angle,
            outer_angle,
            range,
        } => ReportLight {
            kind: "spot",
            position: Some(position.to_array()),
            direction: Some(direction.to_array()),
            inner_angle: Some(inner_angle),
            outer_angle: Some(outer_angle),
            range: Some(range),
            ..bare
        },
        LightKind::Point { position, range } => ReportLight {
            kind: "point",
            position: Some(position.to_array()),
            range: Some(range),
            ..bare
        },
    }
}

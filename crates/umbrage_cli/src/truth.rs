//! `umbrage truth`: a scene's shadow term by rays.

use std::{path::Path, process::ExitCode, time::Instant};

use anyhow::{Context, Result};
use glam::DVec3;
use serde::Serialize;
use umbrage::{
    render::{LeftOut, Picture, Scene},
    shadow::{Field, Light, LightKind},
};
use umbrage_measure::truth::{Source, Truth, TruthStore};

use crate::{
    args::TruthArgs,
    output::{check_picture, print_json, progress},
    render::choose_light,
};

/// Output of `--json`: all that a tracer of another make needs beside the scene's triangles.
#[derive(Serialize)]
struct Report<'a> {
    picture: &'a Path,
    camera: Camera,
    /// The lights whose shadows the picture shows: those that cast some.
    lights: Vec<ReportLight<'a>>,
    triangles: usize,
    /// Features of the models' files that the picture does not show.
    left_out: &'a [LeftOut],
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
    /// Full vertical angle, radians; none of an orthographic camera.
    fov_y: Option<f64>,
    /// From the picture's lower to its upper edge, metres; none of a perspective camera.
    orthographic_height: Option<f64>,
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
    let scene = args.staging.load(&args.scene)?;
    let (scene, lights) = choose_light(scene, args.light)?;
    let store = args.cache.as_ref().map(TruthStore::open).transpose()?;
    let (width, height) = args.size;
    let bar = progress("tracing", Truth::rows(&scene, height));
    let start = Instant::now();
    let traced = trace(args, &scene, store.as_ref(), &|| bar.inc(1))
        .with_context(|| format!("{} cannot be traced", args.scene.display()));
    let milliseconds = start.elapsed().as_secs_f64() * 1e3;
    bar.finish_and_clear();
    let (truth, warnings) = traced?;
    for warning in warnings {
        eprintln!("warning: {warning}");
    }
    let seen = |terms: &Vec<Option<f32>>| terms.iter().map(|term| term.unwrap_or(1.0)).collect();
    let picture = Picture::ShadowTerm(truth.terms.iter().map(seen).collect());
    picture.save_png(width, height, &args.out)?;
    let report = Report {
        picture: &args.out,
        camera: camera(&scene, args.size),
        lights: (lights.iter().zip(&scene.lights))
            .filter(|(_, light)| scene.casts_shadow(light))
            .map(|(index, light)| report_light(*index, &light.name, &light.light))
            .collect(),
        triangles: scene.objects.iter().map(|o| o.mesh.indices.len() / 3).sum(),
        left_out: &scene.left_out,
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
    args: &TruthArgs,
    scene: &Scene,
    store: Option<&TruthStore>,
    on_row: &(dyn Fn() + Sync),
) -> Result<(Truth, Vec<String>)> {
    let sources: Vec<_> = scene
        .lights
        .iter()
        .map(|light| source(args, &light.light))
        .collect();
    match store {
        Some(store) => Ok(store.truth(scene, args.size, &sources, on_row)?),
        None => Ok((
            Truth::trace(scene, args.size, &sources, on_row)?,
            Vec::new(),
        )),
    }
}

/// A light's extent, as the arguments have it.
fn source(args: &TruthArgs, light: &Light) -> Source {
    let Some(size) = args.light_size else {
        return Source::Sharp;
    };
    Source::Round {
        size: match light.kind {
            LightKind::Directional { .. } => size.to_radians(),
            LightKind::Spot { .. } | LightKind::Point { .. } => size,
        },
        strata: args.rays,
    }
}

fn camera(scene: &Scene, (width, height): (u32, u32)) -> Camera {
    let camera = &scene.camera;
    let rotation = camera.rotation.normalize();
    let (fov_y, orthographic_height) = match camera.field {
        Field::Perspective { fov_y } => (Some(fov_y), None),
        Field::Orthographic { height } => (None, Some(height)),
    };
    Camera {
        position: camera.position.to_array(),
        rotation: rotation.to_array(),
        forward: (rotation * DVec3::NEG_Z).to_array(),
        up: (rotation * DVec3::Y).to_array(),
        fov_y,
        orthographic_height,
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

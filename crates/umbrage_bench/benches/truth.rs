//! Cost of a picture of the truth, and how it grows with the triangles: a hilly ground in the
//! evening sun, each with ten times the triangles of the one before.
#![allow(
    clippy::print_stdout,
    reason = "a benchmark reports on standard output"
)]

use std::{error::Error, sync::Arc, time::Instant};

use glam::{DAffine3, DQuat, DVec3, Vec2, Vec3};
use serde::Serialize;
use umbrage_bench::write_report;
use umbrage_measure::truth::{Source, Tracer};
use umbrage_render::{Camera, Material, Mesh, Object, Scene, SceneLight};
use umbrage_shadow::{Field, Light, LightKind};

/// Pixels on each side.
const SIZE: u32 = 512;
/// Fields on each side of the ground; two triangles each.
const GROUNDS: [u32; 3] = [71, 224, 708];

#[derive(Serialize)]
struct Report {
    threads: usize,
    pixels: u32,
    rows: Vec<Row>,
}

#[derive(Serialize)]
struct Row {
    triangles: usize,
    /// To take the scene in and build the tree.
    build_seconds: f64,
    /// To find what is seen and whether it is lit.
    trace_seconds: f64,
    dark_share: f64,
    /// The most that this process has held since it began, in MiB; none where the system does not say.
    peak_mib: Option<f64>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut rows = Vec::new();
    for fields in GROUNDS {
        let row = measure(&scene(fields))?;
        println!(
            "{:8} triangles: {:6.3} s to build, {:6.3} s to trace, {:.1} % dark, peak {} MiB",
            row.triangles,
            row.build_seconds,
            row.trace_seconds,
            100.0 * row.dark_share,
            row.peak_mib
                .map_or("unknown".to_owned(), |mib| format!("{mib:.0}")),
        );
        rows.push(row);
    }
    let report = Report {
        threads: std::thread::available_parallelism()?.get(),
        pixels: SIZE * SIZE,
        rows,
    };
    println!("{}", write_report("truth", &report)?.display());
    Ok(())
}

fn measure(scene: &Scene) -> Result<Row, Box<dyn Error>> {
    let start = Instant::now();
    let tracer = Tracer::new(scene)?;
    let built = Instant::now();
    let sight = tracer.look(SIZE, SIZE, &|| ())?;
    let terms = tracer.shadow(&sight, 0, Source::Sharp, &|| ())?;
    let trace_seconds = built.elapsed().as_secs_f64();
    let dark = terms.iter().filter(|term| **term == Some(0.0)).count();
    Ok(Row {
        triangles: tracer.triangles(),
        build_seconds: (built - start).as_secs_f64(),
        trace_seconds,
        dark_share: dark as f64 / f64::from(SIZE * SIZE),
        peak_mib: peak_mib(),
    })
}

/// The process's high-water mark, by Linux.
fn peak_mib() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kib: f64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib / 1024.0)
}

fn scene(fields: u32) -> Scene {
    let mesh = hills(fields);
    let transform = DAffine3::IDENTITY;
    let eye = DVec3::new(0.0, 6.0, 11.0);
    Scene {
        objects: vec![Object {
            name: "hills".to_owned(),
            bounds: mesh.bounds(&transform),
            mesh: Arc::new(mesh),
            material: Arc::new(Material::plain("lambert")),
            transform,
        }],
        lights: vec![SceneLight {
            name: "sun".to_owned(),
            light: Light {
                kind: LightKind::Directional {
                    direction: DVec3::new(0.8, -0.45, 0.3).normalize(),
                },
                color: Vec3::ONE,
            },
            cookie: None,
            shadow: None,
        }],
        camera: Camera {
            position: eye,
            rotation: DQuat::from_rotation_x(-0.55),
            field: Field::Perspective { fov_y: 1.0 },
            near: 0.1,
            far: 100.0,
        },
        ambient: Vec3::ZERO,
        background: Vec3::ZERO,
        medium: None,
        left_out: Vec::new(),
    }
}

/// A ground 20 m on each side: waves of three lengths, and a roughness of every vertex's own.
fn hills(fields: u32) -> Mesh {
    let row = fields + 1;
    let vertex = |index: u32| {
        let place =
            Vec2::new((index % row) as f32, (index / row) as f32) * (20.0 / fields as f32) - 10.0;
        let wave = |k: f32| (k * place.x).sin() * (0.8 * k * place.y + k).cos() / k;
        // The fraction of a large multiple: a hash that is the same everywhere.
        let rough = (index.wrapping_mul(0x9e37_79b9) >> 8) as f32 / 16_777_216.0;
        let height = wave(0.9) + wave(3.1) + wave(9.7) + 4.0 * rough / fields as f32;
        Vec3::new(place.x, height, place.y)
    };
    let count = row * row;
    let fields = (0..fields).flat_map(|y| (0..fields).map(move |x| y * row + x));
    Mesh {
        positions: (0..count).map(vertex).collect(),
        normals: vec![Vec3::Y; count as usize],
        uvs: vec![Vec2::ZERO; count as usize],
        indices: fields
            .flat_map(|a| [a, a + row, a + row + 1, a, a + row + 1, a + 1])
            .collect(),
        ..Mesh::default()
    }
}

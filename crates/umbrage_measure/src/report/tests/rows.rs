//! Reports made up for the tests.

use std::collections::BTreeMap;

use umbrage_render::LeftOut;

use crate::{
    figures::Figures,
    report::{Decided, Isa, Pictures, Ratio, Report, Row, SceneInfo, Skipped, Spread, difference},
};

/// A row with an error of 0, and a time.
pub(in crate::report) fn row(scene: &str, method: &str, config: &str) -> Row {
    Row {
        scene: scene.to_owned(),
        method: method.to_owned(),
        config: config.to_owned(),
        path: umbrage_render::Path::Forward,
        time_ratio: Ratio::exactly(1.0),
        memory_bytes: 4096,
        ..Row::default()
    }
}

/// A row with an error and its costs.
pub(in crate::report) fn measured(config: &str, error: f64, time_ratio: f64, memory: u64) -> Row {
    let mut row = row("scene", "basic", config);
    row.figures.false_lit = error;
    row.time_ratio = Ratio::exactly(time_ratio);
    row.memory_bytes = memory;
    row
}

/// A row in which no two figures are alike, and none is missing.
pub(in crate::report) fn full_row() -> Row {
    Row {
        figures: Figures {
            compared: 1001,
            left_out: 1002,
            false_lit: 0.11,
            false_shadow: 0.12,
            in_shadow: 0.125,
            false_lit_of_shadow: Some(0.88),
            error_of_shadow: Some(1.84),
            acne: 0.13,
            back_facing: 0.145,
            peter_panning: 0.14,
            leak: 0.15,
            beyond_range: 0.16,
            edge: 0.17,
            rmse: 0.18,
            p99: 0.19,
            edge_p50: Some(2.1),
            edge_p95: Some(2.2),
            edge_max: Some(2.3),
            alias_p95: Some(2.4),
            alias_over_1: Some(0.25),
            alias_perspective_p95: Some(2.6),
            alias_projection_p95: Some(2.7),
            shimmer: Some(0.28),
            flip: Some(0.29),
            bad_pixels: 1003,
        },
        casters_ms: Spread {
            min: 3.1,
            median: 3.2,
            max: 3.3,
        },
        shading_ms: Spread {
            min: 4.1,
            median: 4.2,
            max: 4.3,
        },
        frame_ms: Spread {
            min: 6.1,
            median: 6.2,
            max: 6.3,
        },
        time_ratio: Ratio {
            median: 5.1,
            low: 5.0,
            high: 5.15,
            pairs: 12,
        },
        memory_bytes: 6001,
        texels: 6002,
        texels_written: 6005,
        triangles: 6006,
        vertices: 6007,
        passes: 6003,
        draws: 6004,
        fetches_per_pixel: 5.2,
        fetch_shares: BTreeMap::from([(2, 0.9125), (16, 0.0875)]),
        decided: Some(Decided {
            lit_by_depth: 0.0125,
            lit_by_plane: 0.505,
            shadowed_by_depth: 0.0325,
            shadowed_by_plane: 0.3675,
            filtered: 0.0825,
            fetches_saved: Some(5.3),
        }),
        isa: Some(Isa {
            family: "navi21".to_owned(),
            instructions: 7001,
            vgprs: 7002,
            sgprs: 7003,
            code_size: 7004,
            latency: 7005,
            inverse_throughput: 7006,
        }),
        ..row("scene", "basic", "full")
    }
}

/// Three scenes and twenty configurations, in figures such as real ones have.
pub(super) fn fake_report() -> Report {
    let scenes = ["bunny_sun", "room_point", "leaves"];
    let mut rows = Vec::new();
    for (number, scene) in (0_u32..).zip(scenes) {
        for (method, base, cost) in [
            ("basic", 1.0, 1.0),
            ("vsm", 1.6, 1.35),
            ("evsm", 0.9, 1.5),
            ("pcss", 0.45, 2.6),
        ] {
            for (step, size) in [512_u32, 1024, 2048, 4096, 8192].into_iter().enumerate() {
                rows.push(fake_row(scene, number, method, base, cost, step, size));
            }
        }
    }
    Report {
        adapter: "llvmpipe (LLVM 19.1.7, 256 bits)".to_owned(),
        command: "umbrage compare bunny_sun.ron room_point.ron leaves.ron --out report".to_owned(),
        width: PICTURE.0,
        height: PICTURE.1,
        most_pairs: 40,
        isa_source: "navi21".to_owned(),
        scenes: scenes
            .into_iter()
            .map(|name| SceneInfo {
                name: name.to_owned(),
                lights: 1 + name.len() % 3,
                triangles: 6_000 * name.len(),
                left_out: vec![LeftOut {
                    file: "tree.glb".to_owned(),
                    feature: "animations".to_owned(),
                    places: 2,
                    instead: "the stored pose is drawn".to_owned(),
                }],
            })
            .collect(),
        rows,
        skipped: vec![Skipped {
            scene: "room_point".to_owned(),
            method: "pssm".to_owned(),
            config: "2048 x 4".to_owned(),
            reason: "it splits a view frustum, which a point light does not have; name a sun"
                .to_owned(),
        }],
    }
}

fn fake_row(
    scene: &str,
    number: u32,
    method: &str,
    base: f64,
    cost: f64,
    step: usize,
    size: u32,
) -> Row {
    let wide = f64::from(size);
    // Not quite regular, as measured figures are.
    let wobble = 1.0 + 0.25 * (f64::from(number) * 2.1 + wide.ln() * 3.7 + base * 11.0).sin();
    let error = 12.0 * base / wide * wobble * f64::from(number + 1);
    let texels = u64::from(size) * u64::from(size) * if scene == "room_point" { 6 } else { 1 };
    let bytes = if method == "evsm" { 16 } else { 4 };
    let taps: u32 = if step.is_multiple_of(2) { 1 } else { 9 };
    let ratio = cost * (0.7 + wide / 5000.0 + 0.04 * f64::from(taps)) * wobble;
    let time = |share: f64| Spread {
        min: ratio * share * 0.93,
        median: ratio * share,
        max: ratio * share * 1.21,
    };
    Row {
        figures: Figures {
            compared: 57_600,
            left_out: 131,
            false_lit: error * 0.6,
            false_shadow: error * 0.4,
            in_shadow: 0.2,
            false_lit_of_shadow: Some(error * 3.0),
            error_of_shadow: Some(error * 5.0),
            acne: error * 0.02,
            back_facing: 0.0,
            peter_panning: error * 0.1,
            leak: if method == "vsm" { error * 0.3 } else { 0.0 },
            beyond_range: 0.0,
            edge: error * 0.5,
            rmse: error.sqrt(),
            p99: 1.0,
            edge_p50: Some(800.0 / wide),
            edge_p95: Some(2400.0 / wide),
            edge_max: Some(9000.0 / wide),
            alias_p95: Some(4000.0 / wide),
            alias_over_1: Some((700.0 / wide).min(1.0)),
            alias_perspective_p95: Some(2000.0 / wide),
            alias_projection_p95: Some(2.0),
            shimmer: (scene != "leaves").then_some(error * 0.2),
            flip: Some(error * 0.7),
            bad_pixels: 0,
        },
        casters_ms: time(2.0),
        shading_ms: time(5.0),
        time_ratio: Ratio {
            median: ratio,
            low: ratio * 0.98,
            high: ratio * 1.03,
            pairs: 17,
        },
        memory_bytes: texels * bytes,
        texels,
        texels_written: texels,
        triangles: 18_000,
        vertices: 9_000,
        passes: 1,
        draws: 12,
        fetches_per_pixel: f64::from(taps) + 0.03,
        isa: (method != "pcss").then(|| Isa {
            family: "navi21".to_owned(),
            instructions: 210 + 8 * u64::from(taps),
            vgprs: 24,
            sgprs: 32,
            code_size: 1400 + 60 * u64::from(taps),
            latency: 2200 + 90 * u64::from(taps),
            inverse_throughput: 140 + 9 * u64::from(taps),
        }),
        ..row(
            scene,
            method,
            &format!("{size} pcf{}", if taps == 1 { 1 } else { 3 }),
        )
    }
}

const PICTURE: (u32, u32) = (160, 90);

/// Pictures for each row: a round shadow, coarser the smaller the map is.
pub(super) fn pictures_of(report: &Report) -> Vec<Pictures> {
    let (width, height) = PICTURE;
    let mut scenes: Vec<&str> = report.rows.iter().map(|row| row.scene.as_str()).collect();
    scenes.sort_unstable();
    scenes.dedup();
    let picture = |row: &Row| {
        let place = scenes.binary_search(&row.scene.as_str()).unwrap_or(0);
        let radius = 20.0 + 8.0 * place as f32;
        let shadow = |x: f32, y: f32| {
            let (dx, dy) = (x - 80.0, y - 50.0);
            if dx.hypot(dy) < radius { 0.0 } else { 1.0 }
        };
        let step = row.figures.edge_p50.unwrap_or(1.0).max(0.2) as f32 * 4.0;
        let (mut truth, mut rendered, mut compared) = (Vec::new(), Vec::new(), Vec::new());
        for index in 0..width * height {
            let (x, y) = ((index % width) as f32, (index / width) as f32);
            truth.push((y > 12.0).then(|| shadow(x, y)));
            rendered.push(shadow((x / step).floor() * step, (y / step).floor() * step));
            compared.push(y > 12.0 && index % 211 != 0);
        }
        let difference = difference(&truth, &rendered, &compared, width, height);
        let difference = difference.expect("of one size");
        Pictures::new(&truth, &rendered, difference, None).expect("pictures")
    };
    report.rows.iter().map(picture).collect()
}

//! Exponential maps of an atlas's tiles: what passes make them, from what numbers, and what is refused.

use std::collections::BTreeSet;

use glam::{DQuat, DVec2, DVec3};
use proptest::prelude::*;
use umbrage_shadow::*;
use wgpu_types::{Features, TextureFormat};

use crate::common::{Scene, ground, lamp, passes, post, sun};

fn scene(kind: LightKind, filter: &str, width: u32) -> Scene {
    let mut scene = Scene::new(kind);
    scene.view.position = DVec3::Y * 2.0;
    scene.hold(vec![ground(60.0), post(DVec3::new(3.0, 0.0, -9.0), 4.0)]);
    scene.choose("filter", filter);
    scene.choose("pcf", &width.to_string());
    scene
}

fn computed(plan: &ShadowPlan) -> Vec<&ComputePass> {
    let computed = plan.passes.iter().filter_map(|pass| match pass {
        Pass::Compute(pass) => Some(pass),
        _ => None,
    });
    computed.collect()
}

fn rounded(plan: &ShadowPlan) -> Vec<&ScreenPass> {
    let screens = plan.passes.iter().filter_map(|pass| match pass {
        Pass::Screen(pass) => Some(pass),
        _ => None,
    });
    screens.collect()
}

/// The texture behind a binding of a pass.
fn behind<'a>(pass: &'a ComputePass, binding: &'a str) -> &'a str {
    let mut renamed = pass.reads.renamed.iter();
    let found = renamed.find(|(name, _)| name == binding);
    found.map_or(binding, |(_, source)| &source.name)
}

fn groups(pass: &ComputePass) -> [u32; 3] {
    match pass.workgroups {
        Workgroups::Count(count) => count,
        Workgroups::Indirect { .. } => panic!("their number is known"),
    }
}

fn number(constants: &Constants, name: &str) -> f64 {
    match constants.get(name) {
        Some(Value::F32(value)) => f64::from(*value),
        Some(Value::U32(value)) => f64::from(*value),
        other => panic!("{name}: {other:?}"),
    }
}

fn tiles(plan: &ShadowPlan) -> Vec<Constants> {
    tiles_in(&plan.constants, "esm_tiles")
}

fn tiles_in(constants: &Constants, name: &str) -> Vec<Constants> {
    let Some(Value::Array(tiles)) = constants.get(name) else {
        panic!("no exponential maps");
    };
    let tile = |tile: &Value| match tile {
        Value::Struct(tile) => tile.clone(),
        _ => panic!("no struct"),
    };
    tiles.iter().map(tile).collect()
}

/// All tiles at once, each by its own range and exponent, along their rows and then their columns.
#[test]
fn tiles_are_blurred_in_two_passes() {
    for kind in [sun(), lamp()] {
        for (filter, format, means) in [
            ("esm", TextureFormat::R32Float, "esm_map"),
            ("esm_half", TextureFormat::R16Float, "esm_means"),
            ("esm_log", TextureFormat::R32Float, "esm_map"),
        ] {
            let plan = scene(kind.clone(), filter, 5).plan().expect("a plan");
            let maps = passes(&plan);
            assert!(maps.len() > 2, "{} tiles", maps.len());
            let find = |name: &str| plan.textures.iter().find(|t| t.name == name).expect(name);
            let depths = find("shadow_map");
            let side = maps[0].viewport.width;
            let blurs = computed(&plan);
            let shaders: Vec<_> = blurs.iter().map(|pass| pass.shader.as_str()).collect();
            assert_eq!(shaders, ["esm_across", "esm_down"]);
            for (pass, binding, target) in [
                (blurs[0], "esm_rows", "esm_rows"),
                (blurs[1], "esm_map", means),
            ] {
                assert_eq!(pass.writes, [Source::from(target)]);
                assert_eq!(behind(pass, binding), target);
                let drawn: BTreeSet<_> = cells(&plan).iter().map(|cell| cell[2]).collect();
                assert_eq!(drawn.len(), maps.len());
                let constants = &pass.reads.constants;
                assert_eq!(number(constants, "side") as u32, side);
                let columns = number(constants, "columns") as u32;
                assert_eq!(columns * side, depths.width);
                assert_eq!(tiles_in(constants, "tiles"), tiles(&plan));
                for (number, map) in (0..).zip(&maps) {
                    let corner = [number % columns, number / columns].map(|n| n * side);
                    assert_eq!([map.viewport.x, map.viewport.y], corner);
                }
                let written = find(target);
                assert_eq!(
                    (written.width, written.height),
                    (depths.width, depths.height)
                );
                assert_eq!(
                    written.format,
                    TextureFormat::R32Float,
                    "a compute shader can write it"
                );
            }
            assert_eq!(behind(blurs[1], "esm_rows"), "esm_rows");
            let rounded = rounded(&plan);
            assert_eq!(rounded.is_empty(), means == "esm_map");
            for (pass, map) in rounded.iter().zip(&maps) {
                assert_eq!(
                    (pass.shader.as_str(), &pass.targets[..]),
                    ("esm_round", &["esm_map".into()][..])
                );
                assert_eq!(pass.viewport, map.viewport);
            }
            let read = find("esm_map");
            assert_eq!(read.format, format);
            assert_eq!((read.width, read.height), (depths.width, depths.height));
            for (map, tile) in maps.iter().zip(tiles(&plan)) {
                check_distances(map, number(&tile, "ratio"));
            }
        }
    }
}

/// The cells that are filtered: column, row, map.
fn cells(plan: &ShadowPlan) -> Vec<[u32; 3]> {
    let list = plan
        .buffers
        .iter()
        .find(|buffer| buffer.name == "esm_cells");
    let Some(BufferContents::Value(Value::Array(cells))) = list.map(|list| &list.contents) else {
        panic!("no cells");
    };
    let cell = |cell: &Value| match cell {
        Value::U32(cell) => [cell & 0xfff, cell >> 12 & 0xfff, cell >> 24],
        other => panic!("{other:?}"),
    };
    cells.iter().map(cell).collect()
}

/// A workgroup has 8 × 8 invocations with min(8, W + 1) texels each, 2 where widths differ from map to map; so many as a cell
/// has such parts go to each, and cells cover a tile and no more where air may be seen.
#[test]
fn workgroups_cover_cells_and_no_more() {
    for (width, taper, run) in [(3, "off", 4), (5, "off", 6), (15, "off", 8), (5, "on", 2)] {
        for side in [100.0, 192.0, 193.0] {
            let mut scene = scene(sun(), "esm", width);
            scene.choose("taper", taper);
            scene.set("resolution", side);
            let plan = scene.plan().expect("a plan");
            let blurs = computed(&plan);
            for blur in &blurs {
                let cell = number(&blur.reads.constants, "cell") as u32;
                assert_eq!(cell % (8 * run), 0, "{width}, {side}");
                let [parts, count, 1] = groups(blur) else {
                    panic!("{:?}", groups(blur))
                };
                assert_eq!(parts * 64 * run, cell * cell, "{width}, {side}");
                assert_eq!(count as usize, cells(&plan).len());
            }
            let cell = number(&blurs[0].reads.constants, "cell");
            let mut airy = scene.clone();
            airy.air = Some(ground(9.0));
            let airy = airy.plan().expect("a plan");
            let along = (side / cell).ceil() as usize;
            let all: BTreeSet<_> = cells(&airy).into_iter().collect();
            assert_eq!(all.len(), cells(&airy).len());
            assert_eq!(
                all.len(),
                along * along * passes(&airy).len(),
                "{width}, {side}"
            );
            for (i, tile) in tiles(&plan).iter().enumerate() {
                let narrower = if taper == "on" { 2 * i } else { 0 };
                let expected = (width as usize).saturating_sub(narrower).max(1);
                assert_eq!(number(tile, "width"), expected as f64);
            }
        }
    }
}

/// The shader's formula against the matrix that draws the map: distances along the light's axis, 0 at depth 1 and 1 at
/// depth 0, evenly spaced.
fn check_distances(map: &CasterPass, ratio: f64) {
    let to_world = map.view_proj.as_dmat4().inverse();
    let at = |depth: f64| to_world.project_point3(DVec3::new(0.1, -0.2, depth));
    let all = at(0.0).distance(at(1.0));
    for depth in [0.0, 1e-4, 0.1, 0.5, 0.9, 1.0] {
        let found = (1.0 - depth) / (1.0 + ratio * depth);
        let expected = at(depth).distance(at(1.0)) / all;
        assert!(
            (found - expected).abs() < 1e-4,
            "{depth}: {found}, not {expected}"
        );
    }
}

#[test]
fn a_width_of_one_is_not_blurred() {
    for (filter, target) in [("esm", "esm_map"), ("esm_half", "esm_means")] {
        let plan = scene(sun(), filter, 1).plan().expect("a plan");
        let blurs = computed(&plan);
        assert_eq!(blurs.len(), 1);
        assert_eq!(behind(blurs[0], "esm_rows"), target);
        assert_eq!(blurs[0].writes, [Source::from(target)]);
        assert!(
            plan.textures
                .iter()
                .all(|texture| texture.name != "esm_rows")
        );
    }
}

/// One value alone asks for a feature that only some devices have, and names the others.
#[test]
fn needs_name_what_to_choose_without_them() {
    for (filter, fetches) in [("esm", 1), ("esm_half", 1), ("esm_log", 4)] {
        let plan = scene(sun(), filter, 15).plan().expect("a plan");
        assert_eq!(plan.fetches_per_pixel, fetches);
        if filter == "esm" {
            assert_eq!(plan.needs[0].features, Features::FLOAT32_FILTERABLE);
            assert!(
                plan.needs[0].instead.contains("`esm_half`"),
                "{:?}",
                plan.needs
            );
        } else {
            assert_eq!(plan.needs, []);
        }
    }
}

#[test]
fn what_cannot_be_asked_is_told() {
    let said = |scene: &Scene| {
        let refused = scene.plan().expect_err("refused");
        refused.to_string()
    };
    let mut short = scene(sun(), "esm", 3);
    short.set("exponent", 163.5);
    short.plan().expect("what f32 holds");
    short.set("exponent", 164.0);
    assert_eq!(
        said(&short),
        "the setting `exponent` is 164, but must be 163.6 at the most with the filter `esm`, or 0 for the largest that is of use; `esm_log` holds more"
    );
    let mut half = scene(sun(), "esm_half", 3);
    half.set("exponent", 20.0);
    assert_eq!(
        said(&half),
        "the setting `exponent` is 20, but must be 19.4 at the most with the filter `esm_half`, or 0 for the largest that is of use; `esm` and `esm_log` hold more"
    );
}

/// Chosen by default: 1 % of the light 2 (W + 1) texels below an occluder, for each tile by its own texels, in so far as
/// the format holds it.
#[test]
fn exponents_follow_from_texels() {
    for kind in [sun(), lamp()] {
        for width in [1, 3, 15] {
            for (filter, most) in [("esm", 163.6), ("esm_half", 19.41), ("esm_log", 65536.0)] {
                let plan = scene(kind.clone(), filter, width).plan().expect("a plan");
                for (map, tile) in passes(&plan).iter().zip(tiles(&plan)) {
                    let to_world = map.view_proj.as_dmat4().inverse();
                    // On the light's axis, so that lengths are along it or across.
                    let at =
                        |x: f64, depth: f64| to_world.project_point3(DVec3::new(x, 0.0, depth));
                    let side = f64::from(map.viewport.width);
                    let texel = at(-1.0, 0.0).distance(at(1.0, 0.0)) / side;
                    let axis = match &kind {
                        LightKind::Spot { direction, .. }
                        | LightKind::Directional { direction } => *direction,
                        LightKind::Point { .. } => panic!("no axis"),
                    };
                    let range = (at(0.0, 0.0) - at(0.0, 1.0)).dot(axis);
                    let wanted = 100.0_f64.ln() * range / (2.0 * f64::from(width + 1) * texel);
                    let expected = wanted.clamp(2.0 * 100.0_f64.ln(), most);
                    let found = number(&tile, "exponent");
                    assert!(
                        (found / expected - 1.0).abs() < 2e-3,
                        "{filter} {width}: {found}, not {expected}"
                    );
                }
            }
        }
    }
}

/// A plane does not shade itself in means of exponentials: what would only widen the leak is left out.
#[test]
fn biases_change_nothing() {
    for kind in [sun(), lamp()] {
        let mut scene = scene(kind, "esm", 3);
        let plan = scene.plan().expect("a plan");
        scene.set("depth_bias", 8.0);
        scene.choose("receiver_bias", "constant");
        assert_eq!(scene.plan().expect("a plan"), plan);
    }
}

/// But in a map so small that windows are cut off wherever a receiver lies.
#[test]
fn small_maps_keep_their_bias() {
    let plan = |side: f64, bias: f64| {
        let mut scene = scene(sun(), "esm", 3);
        scene.set("resolution", side);
        scene.set("depth_bias", bias);
        scene.plan_with("basic").expect("a plan")
    };
    assert_ne!(plan(11.0, 0.0), plan(11.0, 1.5));
    assert_eq!(plan(12.0, 0.0), plan(12.0, 1.5));
}

proptest! {
    /// Wherever a receiver is seen, the texels that its filtered map's fetch and their windows read are filtered; in a view
    /// of a part of a large ground, not all are.
    #[test]
    fn all_that_is_read_is_filtered(
        at in prop::collection::vec([-1.0..1.0, -1.0..1.0, -1.0..1.0], 64), yaw in -3.0..3.0, pitch in -1.2..0.3,
        place in [-30.0..30.0, -30.0..30.0, -30.0..30.0], spot in any::<bool>(), fit in 0usize..2,
        transition in 0usize..3, half in 0u32..8, taper in any::<bool>(),
    ) {
        let mut scene = scene(if spot { lamp() } else { sun() }, "esm", 2 * half + 1);
        scene.view.position = DVec3::from(place) + DVec3::Y * 31.0;
        scene.view.rotation = DQuat::from_rotation_y(yaw) * DQuat::from_rotation_x(pitch);
        scene.choose("fit", ["stable", "tight"][fit]);
        scene.choose("transition", ["hard", "blend", "dither"][transition]);
        scene.choose("taper", if taper { "on" } else { "off" });
        let plan = scene.plan()?;
        let maps = passes(&plan);
        if maps.is_empty() {
            return Ok(());
        }
        let listed: BTreeSet<_> = cells(&plan).into_iter().collect();
        let cell = number(&computed(&plan)[0].reads.constants, "cell");
        let side = f64::from(maps[0].viewport.width);
        for t in at {
            let t = DVec3::from(t);
            let receiver = &scene.receivers[usize::from(t.x > 0.8)];
            let point = receiver.center() + 0.5 * t * (receiver.max - receiver.min);
            if !scene.view.frustum().contains(point) {
                continue;
            }
            let relative = point - scene.view.position;
            let depth = relative.dot(scene.view.forward());
            for (number, map) in (0..).zip(&maps) {
                let [start, end] = map.receivers.unwrap_or_default();
                let before = number > 0 && transition > 0;
                let band = maps[(number as usize).saturating_sub(1)].receivers.unwrap_or_default();
                let band = if before { 0.1 * (band[1] - band[0]) } else { 0.0 };
                if !(start - band..end).contains(&depth) {
                    continue;
                }
                let clip = map.view_proj.as_dmat4() * relative.extend(1.0);
                if clip.w <= 0.0 {
                    continue;
                }
                let at = DVec2::new(0.5 + 0.5 * clip.x / clip.w, 0.5 - 0.5 * clip.y / clip.w) * side;
                if at.min_element() < 0.0 || at.max_element() > side {
                    continue;
                }
                let width = f64::from(if taper { half.saturating_sub(number) } else { half }) * 2.0 + 1.0;
                // A step aside, a fetch, and half a window.
                let most = DVec2::splat(std::f64::consts::SQRT_2 * (0.5 * width + 0.5) + 0.5 + 0.5 * width);
                for corner in [-most, most, DVec2::new(most.x, -most.y), DVec2::new(-most.x, most.y)] {
                    let texel = (at + corner).clamp(DVec2::ZERO, DVec2::splat(side - 1.0));
                    let found = (texel / cell).floor().as_uvec2();
                    prop_assert!(listed.contains(&[found.x, found.y, number]), "{texel} of {number}");
                }
            }
        }
    }
}

#[test]
fn what_is_out_of_sight_is_not_filtered() {
    let mut scene = scene(sun(), "esm", 15);
    scene.set("resolution", 2048.0);
    let plan = scene.plan().expect("a plan");
    let whole = 32 * 32 * passes(&plan).len();
    let share = cells(&plan).len() as f64 / whole as f64;
    assert!(share < 0.5, "{share} of all texels");
}

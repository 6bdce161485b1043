//! Inputs of each lookup's shader, computed as it does: all find one place in a split's map, the one that the
//! split's pass draws to.

use glam::{DVec2, DVec3, Mat4, Vec4};
use umbrage_shadow::*;

use crate::common::{Scene, ground, passes, post, sun};

/// Texels and depth by the lookup named, as its shader finds them from the plan, in f32.
fn place(plan: &ShadowPlan, lookup: &str, split: usize, position: DVec3) -> Vec4 {
    let position = position.as_vec3().extend(1.0);
    let member = |value: &Value, name: &str| match value {
        Value::Struct(members) => members.get(name).cloned().expect("a member"),
        _ => panic!("no struct"),
    };
    let matrix = |value: &Value| match value {
        Value::Mat4(value) => *value,
        _ => panic!("no matrix"),
    };
    let vector = |value: Value| match value {
        Value::Vec4(value) => value,
        _ => panic!("no vector"),
    };
    let constant = |name: &str| plan.constants.get(name).expect("a constant").clone();
    let element = |array: &Value| match array {
        Value::Array(values) => values[split].clone(),
        _ => panic!("no array"),
    };
    let projected = match lookup {
        "packed" | "channels" | "masks" => {
            let (scale, depth) = if lookup == "masks" {
                let mask = Vec4::from_array([0, 1, 2, 3].map(|i| f32::from(u8::from(i == split))));
                (
                    matrix(&constant("crop_places")) * mask,
                    matrix(&constant("crop_depths")) * mask,
                )
            } else {
                let crop = element(&constant("crops"));
                (
                    vector(member(&crop, "place")),
                    vector(member(&crop, "depth")),
                )
            };
            let base = matrix(&constant("base")) * position;
            Vec4::new(
                base.x * scale.x + base.w * scale.z,
                base.y * scale.y + base.w * scale.w,
                base.z * depth.x + base.w * depth.y,
                base.w,
            )
        }
        "storage" => {
            let split = match &plan.buffers[0].contents {
                BufferContents::Value(value) => element(value),
                BufferContents::Written(_) => panic!("no value"),
            };
            matrix(&member(&split, "world_to_map")) * position
        }
        "branches" | "weights" => {
            let split = element(&constant("maps"));
            matrix(&member(&split, "world_to_map")) * position
        }
        "matrix_texture" => {
            let texture = plan.textures.iter().find(|t| t.name == "split_matrices");
            let width = texture.expect("a matrix texture").width as usize;
            let bytes = plan.contents[0].bytes.chunks_exact(4);
            let number = |word: &[u8]| f32::from_le_bytes([word[0], word[1], word[2], word[3]]);
            let numbers: Vec<f32> = bytes.map(number).collect();
            let row = |row: usize| Vec4::from_slice(&numbers[4 * (row * width + split)..]);
            Mat4::from_cols(row(0), row(1), row(2), row(3)).transpose() * position
        }
        _ => panic!("an unknown lookup"),
    };
    (projected.truncate() / projected.w).extend(projected.w)
}

/// The split by comparing with all ends at once, as the shader does.
fn chosen(plan: &ShadowPlan, depth: f32) -> usize {
    let Some(Value::Array(ends)) = plan.constants.get("ends") else {
        panic!("no ends")
    };
    let ends = ends.iter().flat_map(|four| match four {
        Value::Vec4(four) => four.to_array(),
        _ => panic!("no vector"),
    });
    ends.filter(|end| depth >= *end).count()
}

#[test]
fn all_lookups_find_what_the_passes_draw() {
    let lamp = LightKind::Spot {
        position: DVec3::new(3.0, 12.0, -14.0),
        direction: DVec3::new(-0.3, -1.0, 0.1).normalize(),
        inner_angle: 0.3,
        outer_angle: 1.0,
        range: 60.0,
    };
    let lookups = [
        "branches",
        "channels",
        "masks",
        "matrix_texture",
        "packed",
        "storage",
        "weights",
    ];
    for (kind, fit) in [
        (sun(), "stable"),
        (sun(), "tight"),
        (lamp.clone(), "stable"),
        (lamp, "tight"),
    ] {
        let mut scene = Scene::new(kind);
        scene.view.position = DVec3::new(0.0, 2.0, 0.0);
        scene.receivers = vec![ground(40.0), post(DVec3::new(1.0, 0.0, -6.0), 2.0)];
        scene.casters = scene.receivers.clone();
        scene.choose("fit", fit);
        for lookup in lookups {
            scene.choose("lookup", lookup);
            let plan = scene.plan().expect("a plan");
            let passes = passes(&plan);
            assert!(passes.len() > 2, "{} passes", passes.len());
            for step in 0..40 {
                let point = DVec3::new(
                    f64::from(step % 5) - 2.0,
                    -2.0,
                    -4.0 - 0.5 * f64::from(step),
                );
                let split = chosen(&plan, -point.z as f32);
                let pass = &passes[split];
                let [start, end] = pass.receivers.expect("view depths");
                assert!(start <= -point.z && -point.z < end);
                let clip = pass.view_proj.as_dmat4().project_point3(point);
                let drawn = DVec2::new(0.5 + 0.5 * clip.x, 0.5 - 0.5 * clip.y) * 1024.0;
                let found = place(&plan, lookup, split, point);
                let apart = (found.as_dvec4().truncate().truncate() - drawn)
                    .abs()
                    .max_element();
                // f32 of numbers up to 1024 and of sums that cancel.
                assert!(apart < 2e-3, "{lookup}: {apart} texels");
                assert!(
                    (f64::from(found.z) - clip.z).abs() < 2e-6,
                    "{lookup}: {}",
                    found.z
                );
            }
        }
    }
}

//! Plans for midpoint maps.

mod common;

use std::collections::BTreeMap;

use common::Scene;
use glam::DVec3;
use umbrage_shadow::*;
use wgpu_types::{Features, TextureFormat};

const SUN: LightKind = LightKind::Directional {
    direction: DVec3::new(0.48, -0.8, 0.36),
};
const LAMP: LightKind = LightKind::Spot {
    position: DVec3::new(0.0, 3.0, -4.0),
    direction: DVec3::NEG_Y,
    inner_angle: 0.4,
    outer_angle: 0.6,
    range: 9.0,
};

/// The plan of `method` for a box on the ground before the camera.
fn plan(method: &str, depth: &str, kind: LightKind) -> Result<ShadowPlan, PlanError> {
    let mut scene = Scene::new(kind);
    scene.view.position = DVec3::Y;
    scene.hold(vec![
        Aabb::new([-5.0, -1.0, -12.0], [5.0, 0.0, -2.0]),
        Aabb::new([-0.5, 0.0, -5.0], [0.5, 1.0, -4.0]),
    ]);
    scene.choose("depth", depth);
    scene.plan_with(method)
}

/// A value of `depth`: passes by their shaders, textures, and fetches for each of `nearest`.
type Variant<'a> = (
    &'a str,
    &'a [(&'a str, usize)],
    &'a [(&'a str, TextureFormat)],
    u32,
);

fn shaders(plan: &ShadowPlan) -> BTreeMap<&str, usize> {
    let mut counts = BTreeMap::new();
    for pass in &plan.passes {
        *counts.entry(pass.shader()).or_insert(0) += 1;
    }
    counts
}

#[test]
fn each_variant_draws_and_owns_what_it_needs_alone() {
    use TextureFormat::{Depth32Float, Rg32Float};
    for method in ["basic", "pssm"] {
        for kind in [SUN, LAMP] {
            let nearest = plan(method, "nearest", kind.clone()).expect("a plan");
            let maps = nearest.passes.len();
            let side = [nearest.textures[0].width, nearest.textures[0].height];
            let variants: [Variant<'_>; 3] = [
                (
                    "midpoint",
                    &[("caster_faces", maps), ("midpoint", maps)],
                    &[("faces", Rg32Float), ("shadow_map", Depth32Float)],
                    1,
                ),
                (
                    "midpoint_sampled",
                    &[("caster_faces", maps)],
                    &[("faces", Rg32Float)],
                    2,
                ),
                (
                    "midpoint_two_passes",
                    &[("caster", 2 * maps), ("midpoint", maps)],
                    &[
                        ("front_faces", Depth32Float),
                        ("back_faces", Depth32Float),
                        ("shadow_map", Depth32Float),
                    ],
                    1,
                ),
            ];
            for (depth, passes, textures, fetches) in variants {
                let found = plan(method, depth, kind.clone()).expect("a plan");
                assert_eq!(shaders(&found), passes.iter().copied().collect(), "{depth}");
                let own = found.textures.iter().map(|t| (t.name.as_str(), t.format));
                assert_eq!(own.collect::<Vec<_>>(), textures, "{depth}");
                assert!(found.textures.iter().all(|t| [t.width, t.height] == side));
                assert_eq!(found.fetches_per_pixel, fetches * nearest.fetches_per_pixel);
            }
        }
    }
}

/// Each map is resolved where it was drawn, with a texel of its own.
#[test]
fn tiles_are_resolved_one_by_one() {
    let plan = plan("pssm", "midpoint", SUN).expect("a plan");
    let drawn = plan.passes.iter().filter_map(|pass| match pass {
        Pass::Casters(pass) => Some(pass.viewport),
        _ => None,
    });
    let resolved = plan.passes.iter().filter_map(|pass| match pass {
        Pass::Screen(pass) => Some((pass.viewport, pass.reads.constants.clone())),
        _ => None,
    });
    let (drawn, resolved): (Vec<_>, Vec<_>) = (drawn.collect(), resolved.collect());
    assert!(drawn.len() > 1);
    let places: Vec<_> = resolved.iter().map(|(tile, _)| *tile).collect();
    assert_eq!(places, drawn);
    let mut margins = resolved.iter().map(|(_, constants)| constants);
    let first = margins.next().expect("a map");
    assert!(margins.all(|margin| margin != first));
}

#[test]
fn what_blends_in_32_bits_says_so_and_what_to_choose() {
    for method in ["basic", "pssm"] {
        for depth in ["midpoint", "midpoint_sampled"] {
            let plan = plan(method, depth, SUN).expect("a plan");
            let need = Need {
                features: Features::FLOAT32_BLENDABLE,
                instead: "`midpoint_two_passes` on the axis `depth`".to_owned(),
            };
            assert_eq!(plan.needs, [need], "{depth}");
        }
        for depth in ["midpoint_two_passes", "nearest"] {
            assert!(plan(method, depth, SUN).expect("a plan").needs.is_empty());
        }
    }
}

/// The bias is the map's, and not the receivers' besides.
#[test]
fn receivers_are_compared_at_their_own_depth() {
    let bias = |depth| match plan("basic", depth, LAMP)
        .expect("a plan")
        .constants
        .get("bias")
    {
        Some(Value::Vec2(bias)) => *bias,
        other => unreachable!("{other:?}"),
    };
    assert!(bias("nearest").y > 0.0);
    for depth in ["midpoint", "midpoint_sampled", "midpoint_two_passes"] {
        assert_eq!(bias(depth), glam::Vec2::ZERO, "{depth}");
    }
}

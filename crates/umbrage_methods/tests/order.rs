//! Maps of another depth order: a part that knows one order refuses the other, and the others heed it.

use std::collections::BTreeMap;

use glam::{DMat4, DVec2, DVec3, Vec3};
use umbrage_shadow::*;

/// A map of the whole of the light's volume.
fn maps(order: DepthOrder) -> Maps {
    Maps {
        order,
        shape: TextureShape::D2,
        size: [64; 2],
        maps: vec![Map {
            tile: Viewport::square(64),
            layer: 0,
            view_proj: DMat4::IDENTITY,
            casters: vec![0],
            receivers: None,
            held: None,
            bias: Bias {
                depth: DVec2::ZERO,
                texel: DVec2::X,
                texels: 0.0,
                rounding: 0.0,
            },
            range: MapRange {
                near: 1.0,
                far: 2.0,
                perspective: false,
                texel: 0.1,
            },
        }],
        follows_plane: false,
    }
}

/// The plan of maps with depths and a filter of these names.
fn plan(order: DepthOrder, depth: &str, filter: &str) -> Result<ShadowPlan, PlanError> {
    let registry = umbrage_methods::registry().expect("names are unique");
    let axes = [
        ("block", "4"),
        ("depth", depth),
        ("filter", filter),
        ("pcf", "3"),
        ("taper", "off"),
    ];
    let axes: BTreeMap<_, _> = axes
        .map(|(axis, value)| (axis.to_owned(), value.to_owned()))
        .into();
    let value = |axis: &str| BTreeMap::get(&axes, axis).map(String::as_str);
    let choice = registry.choose("basic", value).expect("parts");
    let settings = Settings::check(&choice.settings(), []).expect("defaults");
    let frame = Frame {
        view: &View::perspective(DVec3::ZERO, DVec3::NEG_Z, (1.0, 1.0), [0.1, 100.0]),
        light: &Light {
            kind: LightKind::Directional {
                direction: DVec3::NEG_Y,
            },
            color: Vec3::ONE,
        },
        casters: Casters::default(),
        settings: &settings,
        axes: &axes,
        depth: choice.depth.as_deref(),
        filter: choice.filter.as_deref(),
        camera_depth: None,
        answers: Answers::none(),
    };
    let mut plan = ShadowPlan::default();
    frame.fill(&maps(order), &mut plan)?;
    Ok(plan)
}

#[test]
fn nearest_depths_are_those_of_the_order() {
    use wgpu_types::CompareFunction::{GreaterEqual, LessEqual};
    for (order, compare, empty) in [
        (DepthOrder::Reversed, GreaterEqual, 0.0),
        (DepthOrder::Forward, LessEqual, 1.0),
    ] {
        let plan = plan(order, "nearest", "pcf").expect("a plan");
        assert_eq!(plan.textures[0].empty, empty);
        assert_eq!(plan.samplers[0].compare, Some(compare));
        let Some(Pass::Casters(pass)) = plan.passes.first() else {
            unreachable!("casters are drawn")
        };
        let depth = pass.depth.as_ref().expect("a depth");
        assert_eq!(depth.compare, compare);
    }
}

#[test]
fn who_knows_reversed_depth_alone_says_so() {
    for (depth, filter, part) in [
        ("nearest", "esm", "esm"),
        ("nearest", "hpsm", "hpsm"),
        ("nearest", "min_max_tree", "min_max_tree"),
        ("midpoint", "pcf", "midpoint"),
        ("midpoint_sampled", "pcf", "midpoint_sampled"),
    ] {
        plan(DepthOrder::Reversed, depth, filter).expect("a plan");
        let refused = plan(DepthOrder::Forward, depth, filter).expect_err("refused");
        assert_eq!(
            refused.to_string(),
            format!(
                "the order of the maps' depths is Forward, but must be Reversed, as `{part}` knows no other; choose the \
                 depths `nearest` and the filter `pcf`"
            )
        );
    }
}

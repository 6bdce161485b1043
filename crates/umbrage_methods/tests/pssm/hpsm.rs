//! When `hpsm` and its kin build bounds of their maps.

use umbrage_shadow::*;

use crate::common::{Scene, ground, sun};

const ALL: [&str; 4] = ["hpsm", "hpsm_naive", "min_max", "min_max_tree"];

/// Whether a plan for one map of `side` texels builds bounds.
fn is_bounded(filter: &str, width: &str, side: f64, pixels: Option<[u32; 2]>, always: f64) -> bool {
    let mut scene = Scene::basic(sun());
    scene.hold(vec![ground(20.0)]);
    scene.camera_depth = pixels;
    for (axis, value) in [("filter", filter), ("pcf", width)] {
        scene.choose(axis, value);
    }
    for (setting, value) in [("resolution", side), ("always_bounded", always)] {
        scene.set(setting, value);
    }
    let plan = scene.plan_with("basic").expect("a plan");
    let built = plan.passes.iter().filter(|p| matches!(p, Pass::Compute(_)));
    let bounds = plan
        .textures
        .last()
        .expect("bounds, or what stands for them");
    let built = built.count();
    // A texture that no pass writes takes no room.
    assert!(built == 1 || (bounds.width, bounds.height) == (1, 1));
    built == 1
}

/// 64 fetches are halved, less nine: 23 pixels pay for 11.5 texels each.
#[test]
fn bounds_are_built_where_they_pay() {
    for filter in ALL {
        let built = |side, pixels| is_bounded(filter, "15", side, Some(pixels), 0.0);
        assert!(built(1024.0, [320, 285]) && !built(1024.0, [319, 285]));
        assert!(built(2048.0, [1280, 720]) && !built(2048.0, [640, 360]));
        for width in ["1", "3", "5", "7"] {
            assert!(!is_bounded(filter, width, 256.0, Some([3840, 2160]), 0.0));
        }
    }
}

#[test]
fn bounds_are_built_where_they_are_wanted_or_cost_nothing() {
    for filter in ALL {
        for width in ["3", "15"] {
            assert!(is_bounded(filter, width, 4096.0, Some([1, 1]), 1.0));
            assert!(is_bounded(filter, width, 4096.0, None, 0.0));
            // The shader tells bounds from none by a second block.
            assert!(is_bounded(filter, width, 4.0, Some([1, 1]), 0.0));
        }
        assert!(!is_bounded(filter, "15", 5.0, Some([1, 1]), 0.0));
    }
}

/// The maps of all splits are built.
#[test]
fn all_maps_are_to_pay() {
    let mut scene = Scene::new(sun());
    scene.hold(vec![ground(150.0)]);
    scene.choose("filter", "hpsm");
    scene.choose("pcf", "15");
    scene.set("resolution", 1024.0);
    let mut built = |pixels| {
        scene.camera_depth = Some(pixels);
        let plan = scene.plan().expect("a plan");
        let casters = plan.passes.iter().filter(|p| matches!(p, Pass::Casters(_)));
        assert_eq!(casters.count(), 4);
        plan.passes.iter().any(|p| matches!(p, Pass::Compute(_)))
    };
    assert!(built([640, 570]) && !built([639, 570]));
}

//! The lights and cameras of a bare model.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DVec3, Vec3};
use serde_json::{Value, json};
use tempfile::TempDir;
use umbrage_render::SceneLight;
use umbrage_shadow::{Field, LightKind};

use crate::maker::{Maker, assert_near, left_out, load_in, triangle};

/// The triangle, and a node at (1, 2, 3), turned so that it looks down, with what `extra` says of it.
fn with_node(extra: &Value) -> Maker {
    let mut maker = triangle();
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let mut node =
        json!({"translation": [1, 2, 3], "rotation": [-half, 0, 0, half], "scale": [3, 3, 3]});
    for (name, value) in extra.as_object().expect("members") {
        node[name] = value.clone();
    }
    let place = maker.push("nodes", node);
    maker.json["scenes"][0]["nodes"] = json!([0, place]);
    maker
}

fn with_light(light: &Value) -> Maker {
    let mut maker = with_node(&json!({"extensions": {"KHR_lights_punctual": {"light": 0}}}));
    maker.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [light]}});
    maker.json["extensionsUsed"] = json!(["KHR_lights_punctual"]);
    maker
}

fn light(light: &Value) -> SceneLight {
    let scene = with_light(light).scene();
    assert_eq!(left_out(&scene), []);
    assert_eq!(scene.lights.len(), 1, "no sun beside it");
    assert_eq!(
        scene.lights[0].shadow.as_ref().expect("a shadow").method,
        "basic"
    );
    scene.lights[0].clone()
}

#[test]
fn lights_of_a_bare_model_stand_in_the_place_of_the_made_up_sun() {
    let sun = light(
        &json!({"type": "directional", "name": "noon", "color": [1, 0.5, 0.25], "intensity": 90000}),
    );
    let LightKind::Directional { direction } = sun.light.kind else {
        panic!("{sun:?}")
    };
    assert_near(&[direction], &[[0.0, -1.0, 0.0]]);
    assert_eq!(sun.name, "noon");
    // Exposed, whatever its lux: the made-up sun gives 3.
    assert!(
        sun.light.color.abs_diff_eq(Vec3::new(3.0, 1.5, 0.75), 1e-5),
        "{}",
        sun.light.color
    );

    let spot = light(&json!({"type": "spot", "intensity": 5, "range": 7.5,
        "spot": {"innerConeAngle": 0.2, "outerConeAngle": 1.25}}));
    let expected = LightKind::Spot {
        position: DVec3::new(1.0, 2.0, 3.0),
        direction,
        inner_angle: 0.2,
        outer_angle: 1.25,
        range: 7.5,
    };
    assert_eq!(spot.light.kind, expected);
    let defaults = light(&json!({"type": "spot"}));
    let LightKind::Spot {
        inner_angle,
        outer_angle,
        range,
        ..
    } = defaults.light.kind
    else {
        panic!("{defaults:?}")
    };
    assert_eq!((inner_angle, outer_angle), (0.0, PI / 4.0));
    // Without an end: four times as far as the farthest corner, (0 0 0) or one as far beside.
    assert!((range - 4.0 * 14_f64.sqrt()).abs() < 1e-9, "{range}");

    let bulb = light(&json!({"type": "point", "intensity": 100, "range": 100}));
    let LightKind::Point { position, range } = bulb.light.kind else {
        panic!("{bulb:?}")
    };
    assert_eq!((position, range), (DVec3::new(1.0, 2.0, 3.0), 100.0));
    // So that the triangle's middle gets 3.
    let distance = position.distance(DVec3::new(1.0, 1.0, 0.0) / 3.0);
    let window = 1.0 - (distance / 100.0_f64).powi(4);
    let intensity = 3.0 * distance.powi(2) / window;
    assert!(
        (f64::from(bulb.light.color.x) / intensity - 1.0).abs() < 1e-5,
        "{}",
        bulb.light.color
    );
}

#[test]
fn lights_keep_what_they_have_to_each_other() {
    let mut maker = with_light(&json!({"type": "directional", "intensity": 600}));
    maker.push(
        "nodes",
        json!({"extensions": {"KHR_lights_punctual": {"light": 1}}}),
    );
    maker.push("nodes", json!({"extensions": {"KHR_lights_punctual": {"light": 0}, "KHR_node_visibility": {"visible": false}}}));
    maker.json["scenes"][0]["nodes"] = json!([0, 1, 2, 3]);
    let second = json!({"type": "directional", "intensity": 300});
    maker.json["extensions"]["KHR_lights_punctual"]["lights"]
        .as_array_mut()
        .expect("a list")
        .push(second);
    let colors: Vec<_> = maker
        .scene()
        .lights
        .iter()
        .map(|light| light.light.color.x)
        .collect();
    // The hidden one does not shine; both others give 3 together.
    assert!(
        (colors[0] - 2.0).abs() < 1e-5 && (colors[1] - 1.0).abs() < 1e-5,
        "{colors:?}"
    );
    assert_eq!(colors.len(), 2);
}

#[test]
fn lights_that_cannot_shine_are_refused_or_told() {
    let said = |light: Value| with_light(&light).refusal();
    assert!(said(json!({"type": "area"})).contains("its type is `area`"));
    assert!(said(json!({"type": "point", "range": 0})).contains("its range is 0"));
    assert!(said(json!({"type": "point", "intensity": -1})).contains("not negative"));
    let narrow = json!({"type": "spot", "spot": {"innerConeAngle": 0.5, "outerConeAngle": 0.5}});
    assert!(said(narrow).contains("its cone is 0.5 to 0.5"));
    let place = "extensions.KHR_lights_punctual.lights[0]";
    assert!(said(json!({"type": "point", "range": "far"})).contains(place));
    let mut gone = with_light(&json!({"type": "point"}));
    gone.json["extensions"] = json!({});
    assert!(
        gone.refusal().contains("nodes[1]: it names"),
        "{}",
        gone.refusal()
    );

    let wide = json!({"type": "spot", "spot": {"outerConeAngle": FRAC_PI_2}});
    let scene = with_light(&wide).scene();
    assert_eq!(left_out(&scene), [("outerConeAngle beyond 89 degrees", 1)]);
    let LightKind::Spot { outer_angle, .. } = scene.lights[0].light.kind else {
        panic!("{scene:?}")
    };
    assert_eq!(outer_angle, 89_f64.to_radians());
    let mut flat = with_light(&json!({"type": "directional"}));
    flat.json["nodes"][1]["scale"] = json!([0, 0, 0]);
    let scene = flat.scene();
    assert_eq!(
        left_out(&scene),
        [("KHR_lights_punctual without a direction", 1)]
    );
    assert_eq!(scene.lights[0].name, "sun");
}

fn with_camera(camera: &Value) -> Maker {
    let mut maker = with_node(&json!({"camera": 0}));
    maker.push("cameras", camera.clone());
    maker
}

#[test]
fn the_first_camera_of_a_bare_model_looks() {
    let mut maker = with_camera(&json!({"type": "perspective",
        "perspective": {"yfov": 0.7, "znear": 0.25, "zfar": 90, "aspectRatio": 2}}));
    let scene = maker.scene();
    assert_eq!(left_out(&scene), []);
    let camera = &scene.camera;
    assert_near(
        &[
            camera.position,
            camera.rotation * DVec3::NEG_Z,
            camera.rotation * DVec3::Y,
        ],
        &[[1.0, 2.0, 3.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]],
    );
    assert_eq!(camera.field, Field::Perspective { fov_y: 0.7 });
    assert_eq!((camera.near, camera.far), (0.25, 90.0));
    // Without an end it sees all there is, the ground as well.
    maker.json["cameras"][0] =
        json!({"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.25}});
    let scene = maker.scene();
    let corner = |bounds: umbrage_shadow::Aabb| {
        (bounds.min - camera.position)
            .abs()
            .max((bounds.max - camera.position).abs())
            .length()
    };
    let farthest = scene
        .objects
        .iter()
        .map(|object| corner(object.bounds))
        .fold(0.0, f64::max);
    assert!(scene.camera.far > farthest && scene.camera.far < 10.0 * farthest);
    // The lights are still the made-up sun.
    assert_eq!(scene.lights[0].name, "sun");
    // A hidden node's camera looks all the same; a second does not.
    maker.json["nodes"][1]["extensions"] = json!({"KHR_node_visibility": {"visible": false}});
    maker.json["nodes"][0]["camera"] = json!(0);
    let scene = maker.scene();
    assert_eq!(scene.camera.position, DVec3::ZERO);
    assert_eq!(left_out(&scene), [("cameras", 1)]);
}

#[test]
fn an_orthographic_camera_sees_twice_its_magnification() {
    let lens = json!({"xmag": 7, "ymag": 2.5, "znear": 0, "zfar": 20});
    let mut maker = with_camera(&json!({"type": "orthographic", "orthographic": lens}));
    let scene = maker.scene();
    assert_eq!(left_out(&scene), []);
    assert_eq!(scene.camera.field, Field::Orthographic { height: 5.0 });
    assert_eq!((scene.camera.near, scene.camera.far), (0.0, 20.0));
    assert_near(&[scene.camera.rotation * DVec3::NEG_Z], &[[0.0, -1.0, 0.0]]);
    maker.json["cameras"][0]["orthographic"]["ymag"] = json!(0);
    assert!(
        maker.refusal().contains("its ymag is 0"),
        "{}",
        maker.refusal()
    );
}

#[test]
fn cameras_that_cannot_look_are_refused_or_told() {
    let said = |camera: Value| with_camera(&camera).refusal();
    assert!(said(json!({"type": "fisheye"})).contains("its type is `fisheye`"));
    assert!(said(json!({"type": "perspective"})).contains("does not say how"));
    let lens = |yfov: f64, near: f64, far: f64| json!({"type": "perspective", "perspective": {"yfov": yfov, "znear": near, "zfar": far}});
    assert!(said(lens(4.0, 1.0, 2.0)).contains("its yfov is 4"));
    assert!(said(lens(1.0, 0.0, 2.0)).contains("it sees from 0 to 2"));
    assert!(said(lens(1.0, 2.0, 2.0)).contains("it sees from 2 to 2"));
    let mut flat = with_camera(&lens(1.0, 1.0, 2.0));
    flat.json["nodes"][1]["scale"] = json!([0, 0, 0]);
    assert_eq!(
        left_out(&flat.scene()),
        [("cameras without a direction", 1)]
    );
}

#[test]
fn a_scene_file_has_its_own_lights_and_camera() {
    let folder = TempDir::new().expect("a folder");
    let mut maker = with_light(&json!({"type": "point"}));
    maker.push(
        "cameras",
        json!({"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.25}}),
    );
    maker.json["nodes"][1]["camera"] = json!(0);
    let other = triangle();
    for (name, maker) in [("lit.gltf", &maker), ("plain.gltf", &other)] {
        load_in(folder.path(), name, maker.text().as_bytes()).expect("a model");
    }
    let text = r#"(camera: (position: (0, 1, 5), target: (0, 1, 0)), models: [
        (file: "lit.gltf"), (file: "lit.gltf", translation: (1, 0, 0)), (file: "plain.gltf")])"#;
    let scene = load_in(folder.path(), "scene.ron", text.as_bytes()).expect("a scene");
    assert!(scene.lights.is_empty() && scene.camera.position == DVec3::new(0.0, 1.0, 5.0));
    let told: Vec<_> = scene.left_out.iter().map(ToString::to_string).collect();
    assert_eq!(
        told,
        [
            "lit.gltf: KHR_lights_punctual (1 place): the scene file's lights shine",
            "lit.gltf: cameras (1 place): the scene file's camera looks",
        ]
    );
}

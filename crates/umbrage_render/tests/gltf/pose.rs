//! Instances, morph targets, skins and visibility.

use std::{f32::consts::FRAC_1_SQRT_2, sync::Arc};

use glam::Vec3;
use serde_json::json;

use crate::maker::{I8, I16, Maker, U8, U16, assert_near, corners, left_out, triangle};

#[test]
fn instances_stand_within_their_node() {
    let mut maker = triangle();
    let translations = maker.floats(&[[0.0; 3], [10.0, 0.0, 0.0], [0.0, 0.0, 5.0]]);
    // None, a half turn about z, a quarter turn about y; a quarter of 127 turns is 90.
    let rotations = maker.accessor("VEC4", I8, 3, &[0, 0, 0, 127, 0, 0, 127, 0, 0, 90, 0, 90]);
    maker.json["accessors"][rotations]["normalized"] = json!(true);
    let scales = maker.floats(&[[1.0; 3], [2.0, 3.0, 1.0], [1.0; 3]]);
    let own = maker.accessor("SCALAR", U8, 1, &[0]);
    maker.json["nodes"][0]["translation"] = json!([0, 100, 0]);
    maker.json["nodes"][0]["scale"] = json!([2, 2, 2]);
    maker.json["nodes"][0]["extensions"] = json!({"EXT_mesh_gpu_instancing": {"attributes":
        {"TRANSLATION": translations, "ROTATION": rotations, "SCALE": scales, "_ID": own}}});
    maker.json["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
    let scene = maker.scene();
    assert_eq!(scene.objects.len(), 4, "three and a ground");
    let expected = [
        [[0.0, 100.0, 0.0], [2.0, 100.0, 0.0], [0.0, 102.0, 0.0]],
        [[20.0, 100.0, 0.0], [16.0, 100.0, 0.0], [20.0, 94.0, 0.0]],
        [[0.0, 100.0, 10.0], [0.0, 100.0, 8.0], [0.0, 102.0, 10.0]],
    ];
    for (object, expected) in expected.iter().enumerate() {
        assert_near(&corners(&scene, object), expected);
        // One mesh, drawn as instances.
        assert!(Arc::ptr_eq(
            &scene.objects[object].mesh,
            &scene.objects[0].mesh
        ));
        assert!(Arc::ptr_eq(
            &scene.objects[object].material,
            &scene.objects[0].material
        ));
    }
    assert_eq!(left_out(&scene), []);

    let short = maker.floats(&[[0.0; 3]; 2]);
    let extension = &mut maker.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"];
    extension["attributes"]["SCALE"] = json!(short);
    assert!(
        maker.refusal().contains("3 and 2 elements"),
        "{}",
        maker.refusal()
    );
    let many = maker.push(
        "accessors",
        json!({"componentType": 5126, "count": 2_000_000, "type": "VEC3"}),
    );
    let extension = &mut maker.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"];
    extension["attributes"] = json!({"TRANSLATION": many});
    assert!(
        maker.refusal().contains("more than 1048576"),
        "{}",
        maker.refusal()
    );
}

/// A triangle with two morph targets: one lifts the third vertex, one turns all normals.
fn morphed() -> Maker {
    let mut maker = triangle();
    let normals = maker.floats(&[[0.0, 0.0, 1.0]; 3]);
    maker.attribute("NORMAL", normals);
    let lift = maker.floats(&[[0.0; 3], [0.0; 3], [0.0, 4.0, 0.0]]);
    // A target stores nothing for the vertices that it does not move.
    let (indices, values) = (
        maker.view(&[1]),
        maker.view(&[1.0_f32, 0.0, 0.0].map(f32::to_le_bytes).concat()),
    );
    let slide = maker.push("accessors", json!({"componentType": 5126, "count": 3, "type": "VEC3", "sparse":
        {"count": 1, "indices": {"bufferView": indices, "componentType": U8}, "values": {"bufferView": values}}}));
    let turn = maker.floats(&[[2.0, 0.0, 0.0]; 3]);
    let tangents = maker.floats(&[[2.0, 0.0, 0.0]; 3]);
    maker.json["meshes"][0]["primitives"][0]["targets"] =
        json!([{"POSITION": lift}, {"POSITION": slide, "NORMAL": turn, "TANGENT": tangents}]);
    maker
}

#[test]
fn morph_targets_are_taken_as_far_as_the_mesh_or_its_node_says() {
    let mut maker = morphed();
    let shape = |maker: &Maker| {
        let scene = maker.scene();
        assert_eq!(left_out(&scene), []);
        (corners(&scene, 0), scene.objects[0].mesh.normals[0])
    };
    let (found, normal) = shape(&maker);
    assert_near(&found, &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    assert_eq!(normal, Vec3::Z);
    maker.json["meshes"][0]["weights"] = json!([0.25, 0.5]);
    let (found, normal) = shape(&maker);
    assert_near(&found, &[[0.0; 3], [1.5, 0.0, 0.0], [0.0, 2.0, 0.0]]);
    assert!(
        normal.abs_diff_eq(Vec3::new(FRAC_1_SQRT_2, 0.0, FRAC_1_SQRT_2), 1e-6),
        "{normal}"
    );
    maker.json["nodes"][0]["weights"] = json!([-1, 0]);
    let (found, normal) = shape(&maker);
    assert_near(&found, &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, -3.0, 0.0]]);
    assert_eq!(normal, Vec3::Z);

    // Two nodes of one mesh, each in its pose; two in the same share it.
    for weights in [json!([1, 0]), json!([1, 0])] {
        let node = maker.push("nodes", json!({"mesh": 0, "weights": weights}));
        maker.json["scenes"][0]["nodes"]
            .as_array_mut()
            .expect("a list")
            .push(json!(node));
    }
    let scene = maker.scene();
    assert!(!Arc::ptr_eq(&scene.objects[0].mesh, &scene.objects[1].mesh));
    assert!(Arc::ptr_eq(&scene.objects[1].mesh, &scene.objects[2].mesh));
    assert_near(
        &corners(&scene, 1),
        &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 5.0, 0.0]],
    );
}

#[test]
fn morph_targets_move_texture_coordinates_and_colours_too() {
    let mut maker = triangle();
    let uvs = maker.floats(&[[0.0_f32, 0.0]; 3]);
    let colors = maker.floats(&[[0.0_f32, 0.0, 0.0, 0.5]; 3]);
    let (uv_offsets, color_offsets) = (
        maker.floats(&[[0.5_f32, 1.0]; 3]),
        maker.floats(&[[1.0_f32, 0.0, 0.0, 4.0]; 3]),
    );
    maker.attribute("TEXCOORD_0", uvs);
    maker.attribute("COLOR_0", colors);
    maker.json["meshes"][0]["primitives"][0]["targets"] =
        json!([{"TEXCOORD_0": uv_offsets, "COLOR_0": color_offsets}]);
    maker.json["meshes"][0]["weights"] = json!([0.5]);
    let texture = maker.texture(&image::RgbaImage::new(1, 1));
    maker.material(json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": texture}}}));
    let mesh = &maker.scene().objects[0].mesh;
    assert_eq!(mesh.uvs[0].to_array(), [0.25, 0.5]);
    assert_eq!(mesh.colors[0].to_array(), [0.5, 0.0, 0.0, 1.0]);
}

/// A triangle whose third vertex hangs on a second joint by `share`, the rest on the first.
fn skinned(share: [u8; 2]) -> Maker {
    let mut maker = triangle();
    let normals = maker.floats(&[[0.0, 0.0, 1.0]; 3]);
    maker.attribute("NORMAL", normals);
    let joints = maker.accessor("VEC4", U8, 3, &[0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0]);
    let [first, second] = share;
    let weights = maker.accessor(
        "VEC4",
        U8,
        3,
        &[255, 0, 0, 0, 255, 0, 0, 0, first, second, 0, 0],
    );
    maker.json["accessors"][weights]["normalized"] = json!(true);
    maker.attribute("JOINTS_0", joints);
    maker.attribute("WEIGHTS_0", weights);
    // The joints stand at the origin and a metre above it; the second is turned by a quarter about z.
    let half = std::f64::consts::FRAC_1_SQRT_2;
    maker.push("nodes", json!({"children": [2]}));
    maker.push(
        "nodes",
        json!({"translation": [0, 1, 0], "rotation": [0, 0, half, half]}),
    );
    let mut inverses = [[0.0; 16]; 2];
    for inverse in &mut inverses {
        for axis in 0..4 {
            inverse[5 * axis] = 1.0;
        }
    }
    inverses[1][13] = -1.0;
    let inverses = maker.floats(&inverses);
    maker.push(
        "skins",
        json!({"joints": [1, 2], "inverseBindMatrices": inverses, "skeleton": 1}),
    );
    maker.json["nodes"][0]["skin"] = json!(0);
    // By the specification, the mesh's own node is ignored.
    maker.json["nodes"][0]["translation"] = json!([500, 500, 500]);
    maker.json["scenes"][0]["nodes"] = json!([0, 1]);
    maker
}

#[test]
fn skins_bend_meshes_to_their_joints() {
    // The third vertex is at the centre of the second joint's turn: it stays.
    let bind = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let maker = skinned([0, 255]);
    let scene = maker.scene();
    assert_near(&corners(&scene, 0), &bind);
    assert_eq!(left_out(&scene), []);
    // The joint goes a metre along z: the vertex follows, or by its share.
    let mut maker = skinned([0, 255]);
    maker.json["nodes"][2]["translation"] = json!([0, 1, 1]);
    assert_near(
        &corners(&maker.scene(), 0),
        &[bind[0], bind[1], [0.0, 1.0, 1.0]],
    );
    let mut maker = skinned([51, 204]);
    maker.json["nodes"][2]["translation"] = json!([0, 1, 1]);
    assert_near(
        &corners(&maker.scene(), 0),
        &[bind[0], bind[1], [0.0, 1.0, 0.8]],
    );
    // Weights that do not add up to 1 mean their shares; none at all, the first joint.
    let mut maker = skinned([20, 80]);
    maker.json["nodes"][2]["translation"] = json!([0, 1, 1]);
    assert_near(
        &corners(&maker.scene(), 0),
        &[bind[0], bind[1], [0.0, 1.0, 0.8]],
    );
    let mut maker = skinned([0, 0]);
    maker.json["nodes"][2]["translation"] = json!([0, 1, 1]);
    assert_near(&corners(&maker.scene(), 0), &bind);
    // Without inverse matrices the mesh hangs on its joints as it is: (0 1 0), turned, is (−1 0 0).
    let mut maker = skinned([0, 255]);
    maker.json["skins"][0]
        .as_object_mut()
        .expect("members")
        .remove("inverseBindMatrices");
    assert_near(
        &corners(&maker.scene(), 0),
        &[bind[0], bind[1], [-1.0, 1.0, 0.0]],
    );
    // All joints turned: normals turn with them.
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let mut maker = skinned([255, 0]);
    maker.json["nodes"][1]["rotation"] = json!([half, 0, 0, half]);
    let scene = maker.scene();
    assert_near(&corners(&scene, 0), &[bind[0], bind[1], [0.0, 0.0, 1.0]]);
    assert!(scene.objects[0].mesh.normals[0].abs_diff_eq(Vec3::NEG_Y, 1e-6));
    // Mirrored, the front stays where the normals look.
    let mut maker = skinned([255, 0]);
    maker.json["nodes"][1]["scale"] = json!([-1, 1, 1]);
    let scene = maker.scene();
    assert_near(&corners(&scene, 0), &[bind[0], bind[2], [-1.0, 0.0, 0.0]]);
    assert!(scene.objects[0].mesh.normals[0].abs_diff_eq(Vec3::Z, 1e-6));
}

#[test]
fn a_skin_far_out_keeps_its_shape() {
    let mut maker = skinned([255, 0]);
    maker.json["nodes"][1]["translation"] = json!([1e8, 0, 0]);
    let found = corners(&maker.scene(), 0);
    assert_near(
        &found,
        &[[1e8, 0.0, 0.0], [1e8 + 1.0, 0.0, 0.0], [1e8, 1.0, 0.0]],
    );
}

#[test]
fn joints_may_stand_beside_the_scene_and_vertices_hang_on_many() {
    let mut maker = skinned([0, 255]);
    maker.json["scenes"][0]["nodes"] = json!([0]);
    maker.json["nodes"][1]["translation"] = json!([0, 0, 7]);
    maker.json["nodes"][2]["translation"] = json!([0, 1, 1]);
    let expected = [[0.0, 0.0, 7.0], [1.0, 0.0, 7.0], [0.0, 1.0, 8.0]];
    assert_near(&corners(&maker.scene(), 0), &expected);
    // A second set of joints has half of the third vertex's weight.
    let mut maker = skinned([0, 255]);
    let joints = maker.accessor(
        "VEC4",
        U16,
        3,
        &[[0_u8; 8], [0; 8], [0, 0, 0, 0, 0, 0, 0, 0]].concat(),
    );
    let weights = maker.floats(&[[0.0; 4], [0.0; 4], [1.0, 0.0, 0.0, 0.0]]);
    maker.attribute("JOINTS_1", joints);
    maker.attribute("WEIGHTS_1", weights);
    maker.json["nodes"][2]["translation"] = json!([0, 1, 1]);
    let expected = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.5]];
    assert_near(&corners(&maker.scene(), 0), &expected);
}

#[test]
fn skins_that_hold_nothing_are_refused() {
    let said = |change: &dyn Fn(&mut Maker)| {
        let mut maker = skinned([0, 255]);
        change(&mut maker);
        maker.refusal()
    };
    let few = said(&|maker| maker.json["skins"][0]["joints"] = json!([1]));
    assert!(few.contains("joint 1 of 1 holds a vertex"), "{few}");
    let gone = said(&|maker| maker.json["skins"][0]["joints"] = json!([1, 55]));
    assert!(gone.contains("skins[0]: it names nodes[55]"), "{gone}");
    let more = said(&|maker| maker.json["skins"][0]["joints"] = json!([1, 2, 2]));
    assert!(
        more.contains("2 inverse bind matrices for 3 joints"),
        "{more}"
    );
    let free = said(&|maker| {
        let attributes = &mut maker.json["meshes"][0]["primitives"][0]["attributes"];
        attributes
            .as_object_mut()
            .expect("members")
            .remove("JOINTS_0");
    });
    assert!(free.contains("has no JOINTS_0"), "{free}");
    let signed = said(&|maker| {
        let joints = maker.accessor("VEC4", I16, 3, &[0; 24]);
        maker.attribute("JOINTS_0", joints);
    });
    assert!(signed.contains("components of type 5122"), "{signed}");
    // A joint below itself, beside the scene.
    let circle = said(&|maker| {
        maker.json["scenes"][0]["nodes"] = json!([0]);
        maker.json["nodes"][2]["children"] = json!([1]);
    });
    assert!(circle.contains("below itself"), "{circle}");
}

#[test]
fn what_is_hidden_casts_no_shadow() {
    let mut maker = triangle();
    maker.json["extensionsRequired"] = json!(["KHR_node_visibility"]);
    maker.json["nodes"] = json!([
        {"name": "seen", "mesh": 0, "children": [1]},
        {"name": "hidden", "mesh": 0, "children": [2], "extensions": {"KHR_node_visibility": {"visible": false}}},
        {"name": "below", "mesh": 0, "extensions": {"KHR_node_visibility": {"visible": true}}},
        {"name": "by default", "mesh": 0, "extensions": {"KHR_node_visibility": {}}},
    ]);
    maker.json["scenes"][0]["nodes"] = json!([0, 3]);
    let scene = maker.scene();
    let names: Vec<_> = scene
        .objects
        .iter()
        .map(|object| object.name.as_str())
        .collect();
    assert_eq!(names, ["seen", "by default", "ground"]);
    assert_eq!(left_out(&scene), []);
}

//! Valid elements are read, and elements that nothing reads are not looked at.

use std::fs;

use glam::{DVec3, Vec2, Vec3, Vec4};
use serde_json::json;
use tempfile::TempDir;

use crate::maker::{
    F32, I8, I16, Maker, U8, U16, U32, assert_near, corners, glb, left_out, load_in, triangle,
};

const TRIANGLE: [[f64; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

#[test]
fn what_nothing_reads_is_not_looked_at() {
    let mut maker = triangle();
    // An accessor of an application's own, of an unknown type in a view that is not there.
    let own = maker.push(
        "accessors",
        json!({"bufferView": 77, "componentType": 5124, "count": 9e9, "type": "HALF3"}),
    );
    for name in [
        "_FEATURE_ID_0",
        "TANGENT",
        "TEXCOORD_0",
        "TEXCOORD_7",
        "JOINTS_0",
        "MADE_UP",
    ] {
        maker.attribute(name, own);
    }
    maker.json["meshes"][0]["extras"] = json!({"extensions": {"KHR_own": 1}, "targetNames": ["a"]});
    maker.json["nodes"][0]["extras"] = json!([1, {"x": null}]);
    maker.json["extras"] = json!("text");
    maker.push(
        "nodes",
        json!({"mesh": 99, "children": [98], "rotation": "none"}),
    );
    maker.push("cameras", json!({"type": "fisheye"}));
    maker.push("skins", json!({}));
    maker.push("images", json!({"uri": "gone.png"}));
    maker.push("textures", json!({"source": 44}));
    maker.push(
        "materials",
        json!({"pbrMetallicRoughness": {"metallicFactor": -7}}),
    );
    maker.push(
        "meshes",
        json!({"primitives": [{"attributes": {"POSITION": own}}]}),
    );
    maker.push("samplers", json!({"wrapS": 1}));
    let scene = maker.scene();
    assert_near(&corners(&scene, 0), &TRIANGLE);
    assert_eq!(left_out(&scene), []);
}

#[test]
fn pictures_that_nothing_draws_may_be_missing() {
    let mut maker = triangle();
    let gone = maker.push("images", json!({"uri": "normals.png"}));
    let web = maker.push(
        "images",
        json!({"uri": "color.webp", "mimeType": "image/webp"}),
    );
    let red = image::RgbaImage::from_pixel(1, 1, image::Rgba([255, 0, 0, 255]));
    let color = maker.texture(&red);
    maker.json["textures"][color]["extensions"] = json!({"EXT_texture_webp": {"source": web}});
    maker.json["extensionsUsed"] = json!(["EXT_texture_webp"]);
    let normal = maker.push("textures", json!({"source": gone}));
    maker.material(json!({
        "normalTexture": {"index": normal},
        "pbrMetallicRoughness": {"baseColorTexture": {"index": color}},
    }));
    let uvs = maker.floats(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
    maker.attribute("TEXCOORD_0", uvs);
    let scene = maker.scene();
    let texture = scene.objects[0]
        .material
        .base_color_texture
        .as_ref()
        .expect("a texture");
    assert_eq!(texture.image.levels[0].rgba, [[255, 0, 0, 255]]);
    assert_eq!(
        left_out(&scene),
        [("EXT_texture_webp", 1), ("normalTexture", 1)]
    );

    // A texture may have no picture, and then colours nothing.
    maker.json["textures"][color] = json!({});
    let scene = maker.scene();
    assert_eq!(scene.objects[0].material.base_color_texture, None);
    let expected = [
        ("EXT_texture_webp", 1),
        ("normalTexture", 1),
        ("textures without a source", 1),
    ];
    assert_eq!(left_out(&scene), expected);
    // A picture that is drawn must be there.
    maker.json["textures"][color] = json!({"source": gone});
    assert!(
        maker.refusal().contains("normals.png"),
        "{}",
        maker.refusal()
    );
}

/// A sparse accessor that gives elements 1 and 2 the `values`.
fn sparse(
    maker: &mut Maker,
    kind: &str,
    component: u32,
    base: Option<usize>,
    values: &[u8],
) -> usize {
    let indices = maker.view(&[1, 2]);
    let values = maker.view(values);
    let mut accessor = json!({
        "componentType": component, "count": 3, "type": kind,
        "sparse": {
            "count": 2,
            "indices": {"bufferView": indices, "componentType": U8},
            "values": {"bufferView": values},
        },
    });
    if let Some(base) = base {
        accessor["bufferView"] = maker.json["accessors"][base]["bufferView"].clone();
    }
    maker.push("accessors", accessor)
}

fn bytes_of(floats: &[f32]) -> Vec<u8> {
    floats.iter().flat_map(|x| x.to_le_bytes()).collect()
}

#[test]
fn sparse_accessors_change_elements_of_a_view_or_of_zeros() {
    let moved = bytes_of(&[5.0, 0.0, 0.0, 0.0, 6.0, 7.0]);
    let expected = [[0.0, 0.0, 0.0], [5.0, 0.0, 0.0], [0.0, 6.0, 7.0]];
    for base in [None, Some(0)] {
        let mut maker = triangle();
        let positions = sparse(&mut maker, "VEC3", F32, base, &moved);
        maker.attribute("POSITION", positions);
        assert_near(&corners(&maker.scene(), 0), &expected);
    }
    // Indices: 0 1 2 from a view of 2 2 2, and from zeros.
    for base in [false, true] {
        let mut maker = triangle();
        let base = base.then(|| maker.accessor("SCALAR", U16, 3, &[0, 0, 2, 0, 2, 0]));
        let indices = sparse(&mut maker, "SCALAR", U16, base, &[2, 0, 1, 0]);
        maker.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
        let expected = [TRIANGLE[0], TRIANGLE[2], TRIANGLE[1]];
        assert_near(&corners(&maker.scene(), 0), &expected);
    }
    let mut maker = triangle();
    let uvs = sparse(
        &mut maker,
        "VEC2",
        F32,
        None,
        &bytes_of(&[1.0, 0.0, 0.25, 1.0]),
    );
    maker.attribute("TEXCOORD_0", uvs);
    let texture = maker.texture(&image::RgbaImage::new(1, 1));
    maker.material(json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": texture}}}));
    let uvs = &maker.scene().objects[0].mesh.uvs;
    assert_eq!(uvs, &[Vec2::ZERO, Vec2::X, Vec2::new(0.25, 1.0)]);

    let sparse = |change: &dyn Fn(&mut serde_json::Value)| {
        let mut maker = triangle();
        let positions = self::sparse(&mut maker, "VEC3", F32, Some(0), &moved);
        maker.attribute("POSITION", positions);
        change(&mut maker.json["accessors"][positions]);
        maker.refusal()
    };
    let said = sparse(&|accessor| accessor["count"] = json!(2));
    assert!(
        said.contains("accessors[1]: its sparse element 2 is beyond its 2"),
        "{said}"
    );
    let said = sparse(&|accessor| accessor["sparse"]["count"] = json!(3));
    assert!(
        said.contains("accessors[1]: 3 elements of 1 bytes"),
        "{said}"
    );
    let said = sparse(&|accessor| accessor["sparse"]["indices"]["componentType"] = json!(F32));
    assert!(said.contains("sparse indices"), "{said}");
}

#[test]
fn accessors_without_a_view_are_zeros() {
    let mut maker = triangle();
    let zeros = maker.push(
        "accessors",
        json!({"componentType": F32, "count": 3.0, "type": "VEC3"}),
    );
    maker.attribute("NORMAL", zeros);
    assert_eq!(maker.scene().objects[0].mesh.normals, [Vec3::ZERO; 3]);
    maker.json["accessors"][zeros]["count"] = json!(u64::MAX);
    let said = maker.refusal();
    assert!(
        said.contains("elements without data are more than 16777216"),
        "{said}"
    );
}

/// The triangle with positions of another type, twice as large as what is stored.
fn quantized(component: u32, is_normalized: bool, bytes: &[u8]) -> Vec<DVec3> {
    let mut maker = triangle();
    maker.json["nodes"][0]["scale"] = json!([2, 2, 2]);
    let positions = maker.accessor("VEC3", component, 3, bytes);
    let stride = bytes.len() / 3;
    let view = &maker.json["accessors"][positions]["bufferView"];
    let view = view.as_u64().expect("a place") as usize;
    maker.json["bufferViews"][view]["byteStride"] = json!(stride);
    maker.json["accessors"][positions]["normalized"] = json!(is_normalized);
    maker.json["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
    maker.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    maker.attribute("POSITION", positions);
    let scene = maker.scene();
    assert_eq!(left_out(&scene), []);
    corners(&scene, 0)
}

#[test]
fn positions_may_be_small_whole_numbers() {
    // Three vertices of three numbers and a pad: (0 0 0), (most 0 0), (0 least 1).
    let unsigned = |most: f64| [[0.0; 3], [2.0 * most, 0.0, 0.0], [0.0, 0.0, 2.0]];
    let signed =
        |most: f64, least: f64| [[0.0; 3], [2.0 * most, 0.0, 0.0], [0.0, 2.0 * least, 2.0]];
    let u8s = [0, 0, 0, 0, 255, 0, 0, 0, 0, 0, 1, 0];
    let i8s = [0, 0, 0, 0, 127, 0, 0, 0, 0, 128, 1, 0];
    let wide = |narrow: [i32; 12]| -> Vec<u8> {
        narrow
            .iter()
            .flat_map(|x| (*x as u16).to_le_bytes())
            .collect()
    };
    let u16s = wide([0, 0, 0, 0, 65535, 0, 0, 0, 0, 0, 1, 0]);
    let i16s = wide([0, 0, 0, 0, 32767, 0, 0, 0, 0, -32768, 1, 0]);
    assert_near(&quantized(U8, false, &u8s), &unsigned(255.0));
    assert_near(&quantized(I8, false, &i8s), &signed(127.0, -128.0));
    assert_near(&quantized(U16, false, &u16s), &unsigned(65535.0));
    assert_near(&quantized(I16, false, &i16s), &signed(32767.0, -32768.0));
    let share = |corners: [[f64; 3]; 3], of: f64| {
        let [a, b, c] = corners;
        [a, b, [c[0], c[1], c[2] / of]]
    };
    // −128 and −32768 are −1 as well.
    assert_near(&quantized(U8, true, &u8s), &share(unsigned(1.0), 255.0));
    assert_near(&quantized(I8, true, &i8s), &share(signed(1.0, -1.0), 127.0));
    assert_near(&quantized(U16, true, &u16s), &share(unsigned(1.0), 65535.0));
    assert_near(
        &quantized(I16, true, &i16s),
        &share(signed(1.0, -1.0), 32767.0),
    );
}

#[test]
fn normals_and_texture_coordinates_may_be_small_whole_numbers() {
    let mut maker = triangle();
    let normals = maker.accessor("VEC3", I8, 3, &[0, 0, 127, 0, 129, 0, 90, 0, 90]);
    maker.json["accessors"][normals]["normalized"] = json!(true);
    maker.attribute("NORMAL", normals);
    let uvs = maker.accessor("VEC2", U16, 3, &[0, 0, 4, 0, 1, 1, 0, 0, 255, 255, 0, 0]);
    maker.attribute("TEXCOORD_0", uvs);
    let texture = maker.texture(&image::RgbaImage::new(1, 1));
    maker.material(json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": texture}}}));
    let scene = maker.scene();
    let mesh = &scene.objects[0].mesh;
    let expected = [Vec3::Z, Vec3::NEG_Y, Vec3::new(1.0, 0.0, 1.0).normalize()];
    for (normal, expected) in mesh.normals.iter().zip(expected) {
        assert!(normal.abs_diff_eq(expected, 1e-6), "{normal}");
    }
    let expected = [
        Vec2::new(0.0, 4.0),
        Vec2::new(257.0, 0.0),
        Vec2::new(65535.0, 0.0),
    ];
    assert_eq!(mesh.uvs, expected);
    let said = {
        maker.json["accessors"][uvs]["componentType"] = json!(U32);
        maker.json["accessors"][uvs]["count"] = json!(1);
        maker.refusal()
    };
    assert!(
        said.contains("components of type 5125 are not known"),
        "{said}"
    );
}

/// An independent reader reads the same from random data.
#[test]
fn accessors_read_as_the_gltf_crate_reads_them() {
    let mut state = 7_u32;
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        state >> 8
    };
    for round in 0..20 {
        let mut maker = triangle();
        let count = 3 + round;
        let positions: Vec<[f32; 3]> = (0..count)
            .map(|_| std::array::from_fn(|_| random() as f32 / 1e6 - 8.0))
            .collect();
        let positions = maker.floats(&positions);
        let (indices, values) = (
            maker.view(&[0, 2]),
            maker.view(&bytes_of(&std::array::from_fn::<_, 6, _>(|_| {
                random() as f32
            }))),
        );
        maker.json["accessors"][positions]["sparse"] = json!({
            "count": 2,
            "indices": {"bufferView": indices, "componentType": U8},
            "values": {"bufferView": values},
        });
        maker.attribute("POSITION", positions);
        let colors: Vec<u8> = (0..4 * count).map(|_| random() as u8).collect();
        let colors = maker.accessor("VEC4", U8, count, &colors);
        maker.json["accessors"][colors]["normalized"] = json!(true);
        maker.attribute("COLOR_0", colors);
        let uvs: Vec<u8> = (0..4 * count).map(|_| random() as u8).collect();
        let uvs = maker.accessor("VEC2", U16, count, &uvs);
        maker.json["accessors"][uvs]["normalized"] = json!(true);
        maker.attribute("TEXCOORD_0", uvs);
        let indices: Vec<u8> = (0..3 * count)
            .map(|_| (random() as usize % count) as u8)
            .collect();
        let indices = maker.accessor("SCALAR", U8, 3 * count, &indices);
        maker.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
        let texture = maker.texture(&image::RgbaImage::new(1, 1));
        maker.material(json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": texture}}}));

        let other = gltf::Gltf::from_slice_without_validation(maker.text().as_bytes());
        let other = other.expect("read").document;
        let mesh = other.meshes().next().expect("a mesh");
        let primitive = mesh.primitives().next().expect("a primitive");
        let reader = primitive.reader(|_| Some(&maker.bytes));
        let positions: Vec<_> = reader.read_positions().expect("positions").collect();
        let colors = reader.read_colors(0).expect("colours").into_rgba_f32();
        let colors: Vec<_> = colors.collect();
        let uvs: Vec<_> = reader
            .read_tex_coords(0)
            .expect("coordinates")
            .into_f32()
            .collect();
        let indices = reader.read_indices().expect("indices").into_u32();
        let scene = maker.scene();
        let mesh = &scene.objects[0].mesh;
        // Without normals, each triangle has vertices of its own.
        assert_eq!(mesh.indices.len(), 3 * count);
        for (corner, index) in indices.enumerate() {
            let index = index as usize;
            assert_eq!(mesh.positions[corner], Vec3::from(positions[index]));
            assert!(mesh.colors[corner].abs_diff_eq(Vec4::from(colors[index]), 1e-6));
            assert!(mesh.uvs[corner].abs_diff_eq(Vec2::from(uvs[index]), 1e-6));
        }
    }
}

#[test]
fn a_restart_is_no_index() {
    let mut maker = triangle();
    let indices = maker.accessor("SCALAR", U8, 4, &[0, 1, 2, 255]);
    maker.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    maker.json["meshes"][0]["primitives"][0]["mode"] = json!(5);
    let expected = "accessors[1]: element 3 names vertex 255, but the mesh has 3; glTF has no such number for a restart";
    assert!(maker.refusal().contains(expected), "{}", maker.refusal());
    // Of 256 vertices it is one.
    let positions = maker.floats(&[[1.0, 2.0, 3.0]; 256]);
    maker.attribute("POSITION", positions);
    maker.push("nodes", json!({"mesh": 0, "translation": [9, 9, 9]}));
    maker.json["scenes"][0]["nodes"] = json!([0, 1]);
    assert_near(&corners(&maker.scene(), 0), &[[1.0, 2.0, 3.0]; 6]);
}

#[test]
fn a_zero_quaternion_turns_nothing_and_is_told() {
    let mut maker = triangle();
    maker.json["nodes"][0]["rotation"] = json!([0, 0, 0, 0]);
    maker.json["nodes"][0]["translation"] = json!([1, 2, 3]);
    let scene = maker.scene();
    let expected = [[1.0, 2.0, 3.0], [2.0, 2.0, 3.0], [1.0, 3.0, 3.0]];
    assert_near(&corners(&scene, 0), &expected);
    assert_eq!(left_out(&scene), [("rotation of length 0", 1)]);
    // Of any other length it is a rotation.
    maker.json["nodes"][0]["rotation"] = json!([0, 0, 1e-9, 1e-9]);
    let expected = [[1.0, 2.0, 3.0], [1.0, 3.0, 3.0], [0.0, 2.0, 3.0]];
    assert_near(&corners(&maker.scene(), 0), &expected);
}

#[test]
fn data_uris_of_all_kinds_are_read() {
    let mut maker = triangle();
    let standard = {
        let text: serde_json::Value = serde_json::from_str(&maker.text()).expect("JSON");
        let uri = text["buffers"][0]["uri"]
            .as_str()
            .expect("a URI")
            .to_owned();
        uri.split_once(',').expect("a comma").1.to_owned()
    };
    let percent: String = maker
        .bytes
        .iter()
        .map(|byte| format!("%{byte:02X}"))
        .collect();
    let broken_up = standard.replace('A', "A\n ").replace('=', "%3d");
    for uri in [
        format!("data:;base64,{standard}"),
        format!("DATA:application/gltf-buffer;BASE64,{standard}"),
        format!(
            "data:text/plain;charset=utf-8;base64,{}",
            standard.trim_end_matches('=')
        ),
        format!("data:application/octet-stream;base64,{broken_up}"),
        format!("data:application/octet-stream,{percent}"),
    ] {
        maker.json["buffers"] = json!([{"uri": uri, "byteLength": maker.bytes.len()}]);
        assert_near(&corners(&maker.scene(), 0), &TRIANGLE);
    }
    for (uri, expected) in [
        ("data:base64", "no comma"),
        ("data:;base64,!", "bad data URI"),
        ("data:,%4", "no two digits"),
    ] {
        maker.json["buffers"] = json!([{"uri": uri, "byteLength": 36}]);
        assert!(maker.refusal().contains(expected), "{}", maker.refusal());
    }
}

#[test]
fn files_of_all_names_are_read() {
    let folder = TempDir::new().expect("a folder");
    fs::create_dir(folder.path().join("sub dir")).expect("a folder");
    for (uri, name) in [
        ("a b.bin", "a b.bin"),
        ("a%20b.bin", "a b.bin"),
        ("./sub%20dir/x.bin", "sub dir/x.bin"),
        ("größe.bin", "größe.bin"),
        ("gr%C3%B6%C3%9Fe.bin", "größe.bin"),
        // A name that was never encoded.
        ("100%.bin", "100%.bin"),
        ("50%25 off.bin", "50% off.bin"),
        ("a%20raw.bin", "a%20raw.bin"),
    ] {
        let mut maker = triangle();
        fs::write(folder.path().join(name), &maker.bytes).expect("written");
        maker.json["buffers"] = json!([{"uri": uri, "byteLength": maker.bytes.len()}]);
        let scene = load_in(folder.path(), "model.gltf", maker.text().as_bytes());
        assert_near(&corners(&scene.expect(uri), 0), &TRIANGLE);
        fs::remove_file(folder.path().join(name)).expect("removed");
    }
    let mut maker = triangle();
    for (uri, expected) in [
        ("gone.bin", "gone.bin"),
        ("%ff.bin", "percent-encoded"),
        ("file:///x.bin", "not a relative path"),
        // Neither a folder nor a device is read.
        ("sub dir", "cannot read"),
    ] {
        maker.json["buffers"] = json!([{"uri": uri, "byteLength": 36}]);
        let said = load_in(folder.path(), "model.gltf", maker.text().as_bytes());
        let said = said.expect_err("refused").to_string();
        assert!(said.contains(expected), "{said}");
    }
}

#[test]
fn files_may_be_larger_than_they_say() {
    let folder = TempDir::new().expect("a folder");
    let mut maker = triangle();
    let load = |bytes: &[u8]| load_in(folder.path(), "model.glb", bytes).expect("a model");
    let whole = maker.binary();
    assert_near(&corners(&load(&whole), 0), &TRIANGLE);
    // Bytes behind the end, a chunk of an extension, padding, a mark before the text, zeros behind it.
    let behind = [whole.as_slice(), b"more"].concat();
    assert_near(&corners(&load(&behind), 0), &TRIANGLE);
    let buffers = json!([{"byteLength": maker.bytes.len()}]);
    maker.json["buffers"] = buffers;
    let text = ["\u{feff}", &maker.text(), "\0\0"].concat();
    let padded = [maker.bytes.as_slice(), &[9; 6]].concat();
    let chunks = glb(&[
        (b"JSON", text.as_bytes()),
        (b"XTRA", b"of an extension"),
        (b"BIN\0", &padded),
        (b"BIN\0", b"another"),
    ]);
    assert_near(&corners(&load(&chunks), 0), &TRIANGLE);
    for (bytes, expected) in [
        (
            glb(&[(b"BIN\0", b"1234")]),
            "its first chunk is not its JSON",
        ),
        (glb(&[]), "it has no JSON"),
        (glb(&[(b"JSON", b"{}")]), "asset.version"),
        (b"glTF\x01\0\0\0\x0c\0\0\0".to_vec(), "it is glTF 1"),
    ] {
        let said = load_in(folder.path(), "model.glb", &bytes)
            .expect_err("refused")
            .to_string();
        assert!(said.contains(expected), "{said}");
    }
}

#[test]
fn scenes_are_chosen_as_the_file_says() {
    let mut maker = triangle();
    maker.push("nodes", json!({"mesh": 0, "translation": [10, 0, 0]}));
    maker.push("scenes", json!({"nodes": [1]}));
    let x = |maker: &Maker| corners(&maker.scene(), 0)[0].x;
    assert_eq!(x(&maker), 0.0);
    assert_eq!(left_out(&maker.scene()), [("scenes", 1)]);
    maker.json["scene"] = json!(1);
    assert_eq!(x(&maker), 10.0);
    maker.json["scene"] = json!(2);
    let said = maker.refusal();
    assert!(
        said.contains("scene: it names scenes[2], but there are 2"),
        "{said}"
    );
    // Without a default, the first; without scenes, all nodes.
    maker.json.as_object_mut().expect("members").remove("scene");
    assert_eq!(x(&maker), 0.0);
    maker
        .json
        .as_object_mut()
        .expect("members")
        .remove("scenes");
    assert_eq!(maker.scene().objects.len(), 3, "two and a ground");
}

#[test]
fn vertices_that_no_triangle_has_are_no_part_of_a_mesh() {
    let mut maker = triangle();
    let far = [
        [0.0, 0.0, 0.0],
        [9e9, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
    ];
    let positions = maker.floats(&far);
    let normals = maker.floats(&[[0.0, 0.0, 1.0]; 4]);
    let indices = maker.accessor("SCALAR", U8, 3, &[0, 2, 3]);
    maker.attribute("POSITION", positions);
    maker.attribute("NORMAL", normals);
    maker.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    let scene = maker.scene();
    assert_near(&corners(&scene, 0), &TRIANGLE);
    assert_eq!(scene.objects[0].bounds.max, DVec3::new(1.0, 1.0, 0.0));
    assert_eq!(scene.objects[0].mesh.normals.len(), 3);
}

#[test]
fn files_that_need_what_is_not_known_are_refused_by_its_name() {
    for (name, remedy) in [
        ("KHR_draco_mesh_compression", "without compression"),
        ("EXT_meshopt_compression", "without compression"),
        ("KHR_texture_basisu", "PNG or JPEG"),
        ("KHR_made_up", "without the extension"),
    ] {
        let mut maker = triangle();
        maker.json["extensionsRequired"] = json!(["KHR_texture_transform", name]);
        let said = maker.refusal();
        assert!(said.contains(name) && said.contains(remedy), "{said}");
        // An extension that is used but not required is told.
        maker.json["extensionsRequired"] = json!([]);
        maker.json["extensionsUsed"] = json!([name]);
        assert_eq!(left_out(&maker.scene()), [(name, 1)]);
    }
    let mut maker = triangle();
    maker.json["asset"] = json!({"version": "2.0", "minVersion": "2.1"});
    assert!(maker.refusal().contains("glTF 2.1"), "{}", maker.refusal());
    maker.json["asset"] = json!({"version": "1.0"});
    assert!(
        maker.refusal().contains("it is glTF 1.0"),
        "{}",
        maker.refusal()
    );
}

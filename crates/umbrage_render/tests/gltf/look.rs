//! Cut-out surfaces: transformed textures, the opacities of vertices, cut-offs.

use std::f64::consts::FRAC_PI_2;

use glam::{Vec2, Vec4};
use serde_json::{Value, json};
use umbrage_render::Mesh;

use crate::maker::{F32, Maker, U8, U16, left_out, triangle};

/// A textured triangle whose texture coordinates are its positions; `info` is added to what its material says of
/// its texture.
fn textured(info: &Value) -> Maker {
    let mut maker = triangle();
    let uvs = maker.floats(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
    maker.attribute("TEXCOORD_0", uvs);
    let texture = maker.texture(&image::RgbaImage::new(2, 2));
    let mut info = info.clone();
    info["index"] = json!(texture);
    maker.material(json!({"pbrMetallicRoughness": {"baseColorTexture": info}}));
    maker
}

fn mesh(maker: &Maker) -> Mesh {
    let scene = maker.scene();
    assert_eq!(left_out(&scene), []);
    Mesh::clone(&scene.objects[0].mesh)
}

fn uvs(transform: &Value) -> Vec<Vec2> {
    mesh(&textured(
        &json!({"extensions": {"KHR_texture_transform": transform}}),
    ))
    .uvs
}

fn assert_uvs(found: &[Vec2], expected: [[f32; 2]; 3]) {
    for (found, expected) in found.iter().zip(expected) {
        assert!(
            found.abs_diff_eq(expected.into(), 1e-6),
            "{found} is not {expected:?}"
        );
    }
}

#[test]
fn textures_are_transformed_as_their_extension_says() {
    assert_uvs(&uvs(&json!({})), [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
    assert_uvs(
        &uvs(&json!({"offset": [0.5, -2]})),
        [[0.5, -2.0], [1.5, -2.0], [0.5, -1.0]],
    );
    assert_uvs(
        &uvs(&json!({"scale": [3, -1]})),
        [[0.0, 0.0], [3.0, 0.0], [0.0, -1.0]],
    );
    // The extension's example: the lower left quadrant of the picture, turned by a right angle.
    let quadrant = json!({"offset": [0, 1], "rotation": FRAC_PI_2, "scale": [0.5, 0.5]});
    assert_uvs(&uvs(&quadrant), [[0.0, 1.0], [0.0, 0.5], [0.5, 1.0]]);
    // Scaled, then turned (not along the axes), then moved.
    let all = json!({"offset": [1, 2], "rotation": FRAC_PI_2 / 3.0, "scale": [2, 4]});
    let half_root = 3_f32.sqrt() / 2.0;
    let expected = [
        [1.0, 2.0],
        [1.0 + 2.0 * half_root, 1.0],
        [3.0, 2.0 + 4.0 * half_root],
    ];
    assert_uvs(&uvs(&all), expected);
    let said =
        textured(&json!({"extensions": {"KHR_texture_transform": {"scale": [1e300, 1e39]}}}));
    assert!(said.refusal().contains("TEXCOORD_0"), "{}", said.refusal());
}

#[test]
fn a_texture_reads_the_set_that_it_names() {
    let with = |info: &Value| {
        let mut maker = textured(info);
        let second = maker.floats(&[[7.0, 0.0], [8.0, 0.0], [9.0, 0.0]]);
        maker.attribute("TEXCOORD_1", second);
        mesh(&maker).uvs[2]
    };
    assert_eq!(with(&json!({})), Vec2::Y);
    assert_eq!(with(&json!({"texCoord": 1})), Vec2::new(9.0, 0.0));
    let overriding =
        json!({"texCoord": 0, "extensions": {"KHR_texture_transform": {"texCoord": 1}}});
    assert_eq!(with(&overriding), Vec2::new(9.0, 0.0));
    // Missing texture coordinates are told.
    let scene = textured(&json!({"texCoord": 5})).scene();
    assert_eq!(left_out(&scene), [("a missing TEXCOORD_5", 1)]);
}

#[test]
fn colours_of_vertices_come_in_all_types() {
    let expected = [[0.0, 0.2, 1.0], [1.0, 1.0, 1.0], [0.6, 0.4, 0.8]];
    let bytes: Vec<u8> = expected
        .iter()
        .flatten()
        .map(|x| (255.0 * x) as u8)
        .collect();
    let shorts = expected.iter().flatten().map(|x| (65535.0 * x) as u16);
    let shorts: Vec<u8> = shorts.flat_map(u16::to_le_bytes).collect();
    let floats: Vec<u8> = expected
        .iter()
        .flatten()
        .flat_map(|x: &f32| x.to_le_bytes())
        .collect();
    for (component, bytes) in [(U8, bytes), (U16, shorts), (F32, floats)] {
        // Three numbers a vertex, and from the same bytes four of another triangle.
        let mut maker = triangle();
        let view = maker.view(&bytes);
        let accessor = |kind: &str, count: u32| {
            json!({"bufferView": view, "componentType": component, "normalized": component != F32,
                   "count": count, "type": kind})
        };
        let colors = maker.push("accessors", accessor("VEC3", 3));
        maker.attribute("COLOR_0", colors);
        let found = mesh(&maker).colors;
        for (found, expected) in found.iter().zip(expected) {
            let [r, g, b] = expected;
            assert!(found.abs_diff_eq(Vec4::new(r, g, b, 1.0), 1e-5), "{found}");
        }
        let mut maker = triangle();
        let four = [bytes.as_slice(), &bytes[..bytes.len() / 3]].concat();
        let view = maker.view(&four);
        let mut accessor = accessor("VEC4", 3);
        accessor["bufferView"] = json!(view);
        let colors = maker.push("accessors", accessor);
        maker.attribute("COLOR_0", colors);
        let found = mesh(&maker).colors;
        assert!(
            found[0].abs_diff_eq(Vec4::new(0.0, 0.2, 1.0, 1.0), 1e-5),
            "{}",
            found[0]
        );
        assert!(
            found[1].abs_diff_eq(Vec4::new(1.0, 1.0, 0.6, 0.4), 1e-5),
            "{}",
            found[1]
        );
    }
    // Clamped, as glTF has it; white is no colour.
    let mut maker = triangle();
    let colors = maker.floats(&[[2.0, -1.0, 0.5, 7.0]; 3]);
    maker.attribute("COLOR_0", colors);
    assert_eq!(mesh(&maker).colors, [Vec4::new(1.0, 0.0, 0.5, 1.0); 3]);
    let colors = maker.floats(&[[1.0, 1.0, 9.0]; 3]);
    maker.attribute("COLOR_0", colors);
    assert_eq!(mesh(&maker).colors, []);
    let others = maker.floats(&[[0.0; 4]; 3]);
    maker.attribute("COLOR_1", others);
    assert_eq!(left_out(&maker.scene()), [("COLOR_1", 1)]);
}

/// The cut-off of a material of this mode, opacity and texel on a mesh of this opacity, and what is left out.
fn cut(mode: &str, opacity: f32, texel: u8, vertex: f32) -> (Option<f32>, Vec<(String, usize)>) {
    let mut maker = textured(&json!({}));
    let texture = maker.texture(&image::RgbaImage::from_pixel(
        1,
        1,
        image::Rgba([9, 9, 9, texel]),
    ));
    let material = &mut maker.json["materials"][0];
    material["alphaMode"] = json!(mode);
    material["pbrMetallicRoughness"]["baseColorFactor"] = json!([1, 1, 1, opacity]);
    material["pbrMetallicRoughness"]["baseColorTexture"]["index"] = json!(texture);
    let colors = maker.floats(&[[0.5, 0.5, 0.5, vertex]; 3]);
    maker.attribute("COLOR_0", colors);
    let scene = maker.scene();
    let left_out = left_out(&scene)
        .into_iter()
        .map(|(name, count)| (name.to_owned(), count));
    (scene.objects[0].material.alpha_cutoff, left_out.collect())
}

#[test]
fn what_is_blended_is_cut_where_anything_is_less_than_opaque() {
    let told = || vec![("alphaMode BLEND".to_owned(), 1)];
    assert_eq!(cut("OPAQUE", 0.1, 9, 0.1), (None, vec![]));
    assert_eq!(cut("MASK", 1.0, 255, 1.0), (Some(0.5), vec![]));
    assert_eq!(cut("BLEND", 1.0, 255, 1.0), (None, vec![]));
    assert_eq!(cut("BLEND", 0.9, 255, 1.0), (Some(0.5), told()));
    assert_eq!(cut("BLEND", 1.0, 254, 1.0), (Some(0.5), told()));
    assert_eq!(cut("BLEND", 1.0, 255, 0.9), (Some(0.5), told()));
    let mut maker = triangle();
    maker.material(json!({"alphaMode": "DITHER"}));
    assert!(
        maker.refusal().contains("its alphaMode is `DITHER`"),
        "{}",
        maker.refusal()
    );
}

/// Greys with opacity, and 16 bits a channel.
#[test]
fn pictures_of_all_kinds_keep_their_opacity() {
    use image::{DynamicImage, ImageBuffer, ImageFormat, LumaA, Rgba};
    let pictures: [(DynamicImage, [u8; 4]); 3] = [
        (
            DynamicImage::ImageLumaA8(ImageBuffer::from_pixel(1, 1, LumaA([100, 51]))),
            [100, 100, 100, 51],
        ),
        (
            DynamicImage::ImageRgba16(ImageBuffer::from_pixel(
                1,
                1,
                Rgba([65535, 0, 257, 257 * 51]),
            )),
            [255, 0, 1, 51],
        ),
        (
            DynamicImage::ImageLumaA16(ImageBuffer::from_pixel(1, 1, LumaA([0, 65535]))),
            [0, 0, 0, 255],
        ),
    ];
    for (picture, expected) in pictures {
        let mut bytes = std::io::Cursor::new(Vec::new());
        picture
            .write_to(&mut bytes, ImageFormat::Png)
            .expect("encoded");
        let mut maker = textured(&json!({}));
        let view = maker.view(bytes.get_ref());
        // A wrong media type does not keep a picture from being read.
        maker.json["images"][0] = json!({"bufferView": view, "mimeType": "image/jpeg"});
        let scene = maker.scene();
        let texture = scene.objects[0]
            .material
            .base_color_texture
            .as_ref()
            .expect("a texture");
        assert_eq!(texture.image.levels[0].rgba, [expected]);
    }
}

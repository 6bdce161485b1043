//! The scene that a key's permutation is drawn in: small, with a caster of each kind, and lit from
//! where its shadows cross each other and slant steeply.

use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec3, Vec2, Vec3, Vec4};
use umbrage::{
    compose::{Key, Library},
    render::{
        Camera, Image, Level, Material, Medium, Mesh, Object, Scene, SceneLight, Shadow, Texture,
        Wrap,
    },
    shadow::{Field, Light, LightKind},
};

use crate::registry;

/// Squares of the screen's mask along each side.
const MASK: u32 = 4;

/// A scene, and what the oracle must know of its materials.
pub struct Stage {
    /// The scene.
    pub scene: Scene,
    /// The object that has holes.
    pub screen: usize,
    /// Where the screen is solid, by its texture coordinates.
    pub solid: fn(Vec2) -> bool,
}

/// The scene for `key`: its surface, light, cookie and shadow, and a screen whose material has a
/// mask, an alpha test, or both, as the key says.
pub fn stage(library: &Library, key: &Key, resolution: u32) -> Stage {
    let value = |axis: &str| library.axes().value(key, axis).unwrap_or("");
    let on = |axis: &str| value(axis) == "on";
    let mask = on("base_color_texture").then(mask);
    let alpha_test = on("alpha_test");
    let colored = on("vertex_color");
    let solid: fn(Vec2) -> bool = match (alpha_test, mask.is_some(), colored) {
        (true, true, false) => |uv| mask_is_solid((uv * MASK as f32).as_uvec2()),
        (true, true, true) => |uv| uv.x >= 0.5 && mask_is_solid((uv * MASK as f32).as_uvec2()),
        // Without a texture the whole screen is under the cut-off.
        (true, false, _) => |_| false,
        (false, ..) => |_| true,
    };
    let surface = value("surface");
    // Everything has the key's material, so that every permutation is drawn; only the screen's has
    // holes.
    let material = |opacity: f32, mask: &Option<Arc<Image>>| {
        let mut material = Material::plain(surface);
        material.base_color = Vec4::new(0.8, 0.7, 0.6, opacity);
        if value("pass").starts_with("shaft") {
            // Air is all that is seen.
            material.base_color = Vec4::W;
        }
        material.roughness = 0.6;
        material.alpha_cutoff = alpha_test.then_some(0.5);
        material.base_color_texture = mask.as_ref().map(|image| Texture {
            image: Arc::clone(image),
            wrap: [Wrap::Clamp; 2],
            smooth: false,
        });
        Arc::new(material)
    };
    let pass = value("pass");
    let scatters = pass.starts_with("shaft");
    let white = on("base_color_texture").then(|| Arc::new(Image::white()));
    let plain = material(1.0, &white);
    let screen = material(if mask.is_some() { 1.0 } else { 0.2 }, &mask);

    let turned = |position: DVec3, axis: DVec3, degrees: f64, scale: DVec3| {
        let rotation = DQuat::from_axis_angle(axis.normalize(), degrees.to_radians());
        DAffine3::from_scale_rotation_translation(scale, rotation, position)
    };
    let (mut cube, mut quad, mut veil) = (cube(), quad(), quad());
    if colored {
        let opaque = Vec4::new(0.5, 1.0, 0.25, 1.0);
        cube.colors = vec![opaque; cube.positions.len()];
        quad.colors = vec![opaque; quad.positions.len()];
        // Opacity grows from 0 on the left to 1 on the right: the cut-off is in the middle.
        let veiled = veil.uvs.iter().map(|uv| opaque.with_w(uv.x));
        veil.colors = veiled.collect();
    }
    let (cube, quad, veil) = (Arc::new(cube), Arc::new(quad), Arc::new(veil));
    let objects = vec![
        object(
            "ground",
            &quad,
            &plain,
            turned(DVec3::ZERO, DVec3::X, -90.0, DVec3::splat(5.0)),
        ),
        object(
            "box",
            &cube,
            &plain,
            turned(
                DVec3::new(-0.9, 0.4, 0.3),
                DVec3::Y,
                30.0,
                DVec3::splat(0.4),
            ),
        ),
        object(
            "slab",
            &cube,
            &plain,
            turned(
                DVec3::new(0.7, 0.9, -0.5),
                DVec3::new(1.0, 0.3, 0.2),
                35.0,
                DVec3::new(0.5, 0.05, 0.3),
            ),
        ),
        object(
            "screen",
            &veil,
            &screen,
            turned(
                DVec3::new(0.3, 0.5, 0.9),
                DVec3::Y,
                20.0,
                DVec3::new(0.5, 0.5, 1.0),
            ),
        ),
    ];
    let scene = Scene {
        objects,
        lights: vec![light(
            key,
            value("light"),
            on("cookie"),
            value("method"),
            resolution,
            library,
        )],
        camera: Camera {
            position: DVec3::new(1.2, 3.1, 3.6),
            rotation: looking(DVec3::new(1.2, 3.1, 3.6), DVec3::new(0.0, 0.3, 0.0)),
            field: match value("camera") {
                "orthographic" => Field::Orthographic { height: 3.9 },
                _ => Field::Perspective {
                    fov_y: 50f64.to_radians(),
                },
            },
            near: 0.1,
            far: 50.0,
        },
        ambient: Vec3::splat(if pass == "haze" { 1.0 } else { 0.0 }),
        background: Vec3::ZERO,
        medium: (on("medium") || pass == "haze" || scatters).then_some(Medium {
            scattering: if scatters { 0.2 } else { 0.0 },
            absorption: 0.05,
            anisotropy: 0.3,
        }),
        left_out: Vec::new(),
    };
    Stage {
        scene,
        screen: 3,
        solid,
    }
}

fn light(
    key: &Key,
    kind: &str,
    cookie: bool,
    method: &str,
    resolution: u32,
    library: &Library,
) -> SceneLight {
    let position = DVec3::new(-1.1, 2.7, 1.4);
    let target = DVec3::new(0.1, 0.2, 0.0);
    let direction = (target - position).normalize();
    let kind = match kind {
        "spot" => LightKind::Spot {
            position,
            direction,
            inner_angle: 0.5,
            outer_angle: 0.7,
            range: 12.0,
        },
        "point" => LightKind::Point {
            position,
            range: 12.0,
        },
        _ => LightKind::Directional { direction },
    };
    let known = registry();
    let value = |axis: &str| library.axes().value(key, axis);
    // `none` is no method.
    let shadow = known.choose(method, value).ok().map(|choice| {
        let axes = choice.axes().into_iter().map(|axis| {
            let value = value(axis).unwrap_or("");
            (axis.to_owned(), value.to_owned())
        });
        // Bounds of maps do not pay in pictures so small, but are to be seen.
        let wanted = [
            ("resolution", f64::from(resolution)),
            ("always_bounded", 1.0),
        ];
        let known = choice.settings();
        let wanted = wanted
            .into_iter()
            .filter(|(name, _)| known.iter().any(|s| s.name == *name));
        Shadow {
            method: method.to_owned(),
            axes: axes.collect(),
            settings: wanted
                .map(|(name, value)| (name.to_owned(), value))
                .collect(),
        }
    });
    SceneLight {
        name: "light".to_owned(),
        light: Light {
            kind,
            // Air dims ambient light alone, and scatters little of a lamp's.
            color: Vec3::splat(match library.axes().value(key, "pass") {
                Some("haze") => 0.0,
                Some("shafts" | "shaft_fetches") => 800.0,
                _ if library.axes().value(key, "medium") == Some("on") => 12.0,
                _ => 8.0,
            }),
        },
        cookie: cookie.then(|| Arc::new(Image::white())),
        shadow,
    }
}

fn object(name: &str, mesh: &Arc<Mesh>, material: &Arc<Material>, transform: DAffine3) -> Object {
    Object {
        name: name.to_owned(),
        mesh: Arc::clone(mesh),
        material: Arc::clone(material),
        transform,
        bounds: mesh.bounds(&transform),
    }
}

fn looking(from: DVec3, to: DVec3) -> DQuat {
    let back = (from - to).normalize();
    let right = DVec3::Y.cross(back).normalize();
    DQuat::from_mat3(&glam::DMat3::from_cols(right, back.cross(right), back))
}

/// A square of side 2 in the plane of x and y.
fn quad() -> Mesh {
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    Mesh {
        positions: corners.map(|(x, y)| Vec3::new(x, y, 0.0)).to_vec(),
        normals: vec![Vec3::Z; 4],
        uvs: corners
            .map(|(x, y)| Vec2::new(0.5 + 0.5 * x, 0.5 - 0.5 * y))
            .to_vec(),
        indices: vec![0, 1, 2, 0, 2, 3],
        ..Mesh::default()
    }
}

/// A cube of side 2, with its faces' own normals.
fn cube() -> Mesh {
    let mut cube = Mesh::default();
    for axis in 0..3 {
        for side in [-1.0f32, 1.0] {
            let mut normal = [0.0; 3];
            normal[axis] = side;
            let normal = Vec3::from(normal);
            let across = Vec3::new(normal.y, normal.z, normal.x);
            let up = normal.cross(across);
            let first = cube.positions.len() as u32;
            for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                cube.positions.push(normal + across * x + up * y);
                cube.normals.push(normal);
                cube.uvs.push(Vec2::new(0.5 + 0.5 * x, 0.5 - 0.5 * y));
            }
            cube.indices
                .extend([0, 1, 2, 0, 2, 3].map(|index| first + index));
        }
    }
    cube
}

fn mask() -> Arc<Image> {
    let texels = (0..MASK * MASK).map(|index| {
        let solid = mask_is_solid(glam::UVec2::new(index % MASK, index / MASK));
        [255, 255, 255, if solid { 255 } else { 0 }]
    });
    // One level: a smaller one would blur the squares' edges, which the oracle draws sharp.
    let level = Level {
        width: MASK,
        height: MASK,
        rgba: texels.collect(),
    };
    Arc::new(Image {
        levels: vec![level],
    })
}

fn mask_is_solid(square: glam::UVec2) -> bool {
    (square.x + square.y).is_multiple_of(2)
}

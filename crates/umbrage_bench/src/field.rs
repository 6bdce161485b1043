//! A field of boxes in the sun: a ground, and as many boxes as are asked for on the same area.

use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec3, Vec2, Vec3};
use umbrage_render::{Camera, Material, Mesh, Object, Scene, SceneLight};
use umbrage_shadow::{Field as Seen, Light, LightKind};

/// Metres along each side of the ground.
const SIDE: f64 = 64.0;

/// Meshes, and materials, that the boxes are shared out among.
const KINDS: usize = 4;

/// The order in which the scene lists its boxes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Those of one mesh and material together, as they stand in the field.
    Sorted,
    /// Mixed. The picture is the same.
    Shuffled,
}

/// The scene with `boxes` boxes, a square number; the ground is the last of its objects.
pub fn field(boxes: usize, order: Order) -> Scene {
    let across = boxes.isqrt();
    let cell = SIDE / across as f64;
    let meshes: Vec<_> = (0..KINDS)
        .map(|kind| {
            let height = 0.5 + 0.25 * kind as f32;
            Arc::new(Mesh::cuboid(Vec3::new(0.45, height, 0.45) * cell as f32))
        })
        .collect();
    let materials: Vec<_> = (0..KINDS)
        .map(|kind| {
            let shade = 0.3 + 0.2 * kind as f32;
            let color = Vec3::new(shade, 0.6, 1.0 - shade).extend(1.0);
            Arc::new(Material {
                base_color: color,
                ..Material::plain(["lambert", "ggx"][kind % 2])
            })
        })
        .collect();
    let mut objects: Vec<_> = (0..boxes)
        .map(|place| {
            let group = place * KINDS * KINDS / boxes;
            let mesh = &meshes[group / KINDS];
            let middle = |at: usize| (at as f64 + 0.5) * cell - 0.5 * SIDE;
            let height = f64::from(mesh.positions.iter().fold(0.0_f32, |y, p| y.max(p.y)));
            let at = DVec3::new(middle(place % across), height, middle(place / across));
            object(
                format!("box {place}"),
                mesh,
                &materials[group % KINDS],
                DAffine3::from_translation(at),
            )
        })
        .collect();
    if order == Order::Shuffled {
        let sorted = objects.clone();
        let mixed = shuffled(boxes);
        objects = mixed.into_iter().map(|at| sorted[at].clone()).collect();
    }
    let ground = Arc::new(Mesh::plane(Vec2::splat(SIDE as f32), Vec2::ONE));
    let plain = Arc::new(Material::plain("lambert"));
    objects.push(object(
        "ground".to_owned(),
        &ground,
        &plain,
        DAffine3::IDENTITY,
    ));
    let sun = Light {
        kind: LightKind::Directional {
            direction: DVec3::new(0.5, -0.7, -0.4).normalize(),
        },
        color: Vec3::ONE,
    };
    let mut scene = Scene {
        objects,
        lights: vec![SceneLight {
            name: "sun".to_owned(),
            light: sun,
            cookie: None,
            shadow: None,
        }],
        camera: Camera {
            position: DVec3::ZERO,
            rotation: DQuat::from_rotation_x(-0.35),
            field: Seen::Perspective { fov_y: 0.9 },
            near: 0.1,
            far: 200.0,
        },
        ambient: Vec3::splat(0.1),
        background: Vec3::ZERO,
        medium: None,
        left_out: Vec::new(),
    };
    look(&mut scene, 0);
    scene
}

/// Places the camera where it is in frame `frame` of a slow walk, there and back.
pub fn look(scene: &mut Scene, frame: usize) {
    let step = (frame % 400).abs_diff(200) as f64;
    scene.camera.position = DVec3::new(0.013 * step, 12.0, 44.0 - 0.021 * step);
}

/// Moves the box at this place of the list a little aside.
pub fn nudge(scene: &mut Scene, place: usize) {
    let object = &mut scene.objects[place];
    object.transform.translation.x += 0.05;
    object.bounds = object.mesh.bounds(&object.transform);
}

fn object(name: String, mesh: &Arc<Mesh>, material: &Arc<Material>, transform: DAffine3) -> Object {
    Object {
        name,
        bounds: mesh.bounds(&transform),
        mesh: Arc::clone(mesh),
        material: Arc::clone(material),
        transform,
    }
}

/// The numbers below `count` in an order that is the same everywhere.
fn shuffled(count: usize) -> Vec<usize> {
    let mut numbers: Vec<_> = (0..count).collect();
    let mut state = 1_u64;
    for last in (1..count).rev() {
        // A linear congruential generator by Knuth; its high bits are mixed well enough for this.
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        numbers.swap(last, (state >> 33) as usize % (last + 1));
    }
    numbers
}

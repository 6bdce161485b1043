//! Triangles that the rasteriser draws against those that rays meet.

mod common;

use std::{collections::BTreeMap, path::PathBuf};

use glam::{DVec2, Vec4Swizzles as _};
use umbrage_measure::truth::Tracer;
use umbrage_render::{Picture, RenderOptions, Renderer, Scene, What};

use common::renderer;

const SIZE: (u32, u32) = (320, 240);
/// Pixels that a rasteriser may move a corner by: Vulkan asks for a grid of a sixteenth at the least.
const GRID: f64 = 1.0 / 16.0;
/// Rays along a pixel's side: odd, so that the middle one goes through the pixel's middle. Many
/// triangles are smaller than a pixel.
const FINER: u32 = 5;

/// The example scenes by name.
fn examples() -> BTreeMap<String, Scene> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../examples/scenes");
    let files = std::fs::read_dir(folder).expect("the scenes' folder");
    let paths = files.map(|entry| entry.expect("an entry").path());
    let scenes = paths.filter(|path| path.extension().is_some_and(|end| end == "ron"));
    scenes
        .map(|path| {
            let name = path.file_stem().unwrap_or_default().to_string_lossy();
            (
                name.into_owned(),
                Scene::load(&path).expect("a sound scene"),
            )
        })
        .collect()
}

type Seen = Option<(u32, u32)>;

/// Points that rays see, many a pixel.
struct Rays(Vec<Seen>);

impl Rays {
    fn new(scene: &Scene) -> Self {
        let tracer = Tracer::new(scene).expect("a sound scene");
        let (width, height) = (SIZE.0 * FINER, SIZE.1 * FINER);
        let sight = tracer.look(width, height, &|| ()).expect("a size");
        let seen = sight.seen().iter();
        Self(
            seen.map(|seen| seen.map(|seen| (seen.object, seen.triangle)))
                .collect(),
        )
    }

    fn at(&self, x: u32, y: u32) -> Seen {
        self.0[(y * SIZE.0 * FINER + x) as usize]
    }

    /// Point that the ray through the pixel's middle sees.
    fn middle(&self, pixel: usize) -> Seen {
        let (x, y) = place(pixel);
        self.at(x * FINER + FINER / 2, y * FINER + FINER / 2)
    }

    /// Points that the rays of the pixel and of its eight neighbours see.
    fn around(&self, pixel: usize) -> impl Iterator<Item = Seen> {
        let (x, y) = place(pixel);
        let near = |at: u32, end: u32| at.saturating_sub(1) * FINER..(at + 2).min(end) * FINER;
        near(y, SIZE.1).flat_map(move |y| near(x, SIZE.0).map(move |x| self.at(x, y)))
    }
}

fn place(pixel: usize) -> (u32, u32) {
    (pixel as u32 % SIZE.0, pixel as u32 / SIZE.0)
}

fn by_rasteriser(renderer: &mut Renderer, scene: &Scene) -> Vec<Seen> {
    let options = RenderOptions {
        width: SIZE.0,
        height: SIZE.1,
        what: What::Triangles,
        ..RenderOptions::default()
    };
    match renderer.render(scene, &options).expect("renders").picture {
        Picture::Triangles(seen) => seen,
        _ => unreachable!("triangles were asked for"),
    }
}

/// How far an edge of the triangle is from the pixel's middle, in pixels; a triangle that reaches behind
/// the camera has none.
fn edge_distance(scene: &Scene, (object, triangle): (u32, u32), pixel: usize) -> f64 {
    let object = &scene.objects[object as usize];
    let view = scene.camera.view(SIZE.0, SIZE.1);
    let size = DVec2::new(SIZE.0.into(), SIZE.1.into());
    let first = 3 * triangle as usize;
    let corners = [0, 1, 2].map(|corner| {
        let index = object.mesh.indices[first + corner] as usize;
        let position = object.mesh.positions[index].as_dvec3();
        let at = object.transform.transform_point3(position) - view.position;
        let clip = view.view_proj_relative() * at.extend(1.0);
        let ndc = clip.xy() / clip.w;
        (clip.w > 0.0).then(|| (DVec2::new(ndc.x, -ndc.y) * 0.5 + 0.5) * size)
    });
    let (x, y) = place(pixel);
    let middle = DVec2::new(x.into(), y.into()) + 0.5;
    let distance = |from: usize, to: usize| {
        let (start, along) = (corners[from]?, corners[to]? - corners[from]?);
        let part = (middle - start).dot(along) / along.length_squared();
        Some((start + along * part.clamp(0.0, 1.0)).distance(middle))
    };
    let distances = [(0, 1), (1, 2), (2, 0)].map(|(from, to)| distance(from, to));
    distances
        .into_iter()
        .flatten()
        .fold(f64::INFINITY, f64::min)
}

/// A rasteriser moves corners to a grid of its own and depth has its steps: at a border it may see what
/// lies on the other side, and nowhere else.
#[test]
fn rasteriser_and_rays_see_the_same_triangles() {
    let mut renderer = renderer();
    let examples = examples();
    assert!(!examples.is_empty(), "no scene: nothing would be tested");
    for (name, scene) in examples {
        let rays = Rays::new(&scene);
        let truth: Vec<_> = (0..(SIZE.0 * SIZE.1) as usize)
            .map(|pixel| rays.middle(pixel))
            .collect();
        let drawn = by_rasteriser(&mut renderer, &scene);
        assert_eq!(drawn.len(), truth.len());
        let wrong: Vec<_> = (0..truth.len())
            .filter(|pixel| truth[*pixel] != drawn[*pixel])
            .collect();
        println!("{name}: {} of {} differ", wrong.len(), truth.len());
        assert!(
            200 * wrong.len() <= truth.len(),
            "{name}: {} of {} differ",
            wrong.len(),
            truth.len()
        );
        // Most of a scene is seen, and by more than one triangle, or agreeing would be easy.
        let seen = truth.iter().flatten().count();
        assert!(2 * seen > truth.len(), "{name}: {seen} see something");
        for pixel in wrong {
            // A sliver may lie between all rays, but not away from the middle that it was drawn at.
            assert!(
                rays.around(pixel).any(|seen| seen == drawn[pixel])
                    || drawn[pixel].is_some_and(|seen| edge_distance(&scene, seen, pixel) < GRID),
                "{name}: pixel {pixel} sees {:?}, and rays around it see none of it",
                drawn[pixel]
            );
        }
    }
}

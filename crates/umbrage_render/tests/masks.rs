//! The mask path draws what the forward path draws.

mod common;

use common::{example, methods, renderer, scene, small};
use umbrage_render::{Path, Picture, RenderOptions, Rendered, Renderer, Scene, What};

const SCENES: [&str; 4] = [
    "bunny_sun.ron",
    "leaves.ron",
    "room_point.ron",
    "suzanne_spot.ron",
];

fn options(what: What, path: Path) -> RenderOptions {
    RenderOptions {
        width: 480,
        height: 360,
        what,
        path,
        ..RenderOptions::default()
    }
}

fn both(renderer: &mut Renderer, scene: &Scene, what: What) -> [Rendered; 2] {
    [Path::Forward, Path::Mask].map(|path| {
        let rendered = renderer.render(scene, &options(what, path));
        rendered.expect("renders")
    })
}

#[test]
fn measure() {
    let mut renderer = renderer(methods());
    for name in SCENES {
        let scene = example(name);
        let [a, b] = both(&mut renderer, &scene, What::ShadowTerm);
        let (Picture::ShadowTerm(a), Picture::ShadowTerm(b)) = (&a.picture, &b.picture) else { panic!() };
        let mut d: Vec<f32> = a[0].iter().zip(&b[0]).map(|(a, b)| (a - b).abs()).collect();
        d.sort_by(f32::total_cmp);
        let mid = a[0].iter().filter(|t| **t > 0.0 && **t < 1.0).count();
        let n = d.len();
        println!("{name}: nonzero {} of {n}, penumbra {mid}; max {} {} {} ; >1e-4 {} >1/256 {} > 0.01 {} >0.02 {}", d.iter().filter(|d| **d > 0.0).count(), d[n-1], d[n-10], d[n-100],
            d.iter().filter(|d| **d > 1e-4).count(),
            d.iter().filter(|d| **d > 1.0/256.0).count(),
            d.iter().filter(|d| **d > 0.01).count(),
            d.iter().filter(|d| **d > 0.02).count());
        let [a, b] = both(&mut renderer, &scene, What::Shaded);
        let (Picture::Shaded(a), Picture::Shaded(b)) = (&a.picture, &b.picture) else { panic!() };
        let mut d: Vec<f32> = a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| (a - b).abs()).collect();
        d.sort_by(f32::total_cmp);
        println!("   shaded max {} {} nonzero {}", d[d.len()-1], d[d.len()-100], d.iter().filter(|d| **d > 0.0).count());
    }
}

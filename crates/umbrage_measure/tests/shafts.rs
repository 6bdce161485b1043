//! The light that air scatters, against a march whose shadows are rays in f64.

mod common;

use std::{f64::consts::PI, path::PathBuf, sync::Arc};

use glam::{DVec2, DVec3, Vec3, Vec4};
use umbrage_measure::truth::Tracer;
use umbrage_render::{Material, Medium, Picture, RenderOptions, Scene, Shadow};
use umbrage_shadow::{LightKind, Pass};

use common::renderer;

const SIZE: (u32, u32) = (30, 20);
/// Steps of the march, and of the picture.
const TRUE_STEPS: u32 = 400;
const STEPS: u32 = 1024;
/// Texels by which a shadow's side may be off in a map: half a filter of three, its bilinear taps' half texel, and the
/// bias of one and a half.
const TEXELS: f64 = 3.5;

/// A barn with a sun through its gaps, all black: what is seen is the air.
fn barn(method: &str) -> Scene {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../examples/scenes");
    let mut scene = Scene::load(folder.join("shafts.ron")).expect("a sound scene");
    let black = Arc::new(Material {
        base_color: Vec4::W,
        ..Material::plain("lambert")
    });
    for object in &mut scene.objects {
        object.material = Arc::clone(&black);
    }
    (scene.ambient, scene.background) = (Vec3::ZERO, Vec3::ZERO);
    scene.lights[0].light.color = Vec3::splat(10.0);
    scene.lights[0].shadow = Some(Shadow {
        method: method.to_owned(),
        settings: [("resolution".to_owned(), 4096.0)].into(),
        ..Shadow::default()
    });
    scene
}

#[test]
fn shafts_are_where_rays_say() {
    for method in ["basic", "pssm"] {
        let scene = barn(method);
        let options = RenderOptions {
            width: SIZE.0,
            height: SIZE.1,
            shaft_steps: STEPS,
            ..RenderOptions::default()
        };
        let rendered = renderer().render(&scene, &options).expect("renders");
        let Picture::Shaded(pixels) = &rendered.picture else {
            unreachable!("a shaded picture was asked for")
        };
        let plan = rendered.report.plans[0].as_ref().expect("a plan");
        // The coarsest map's texels, in metres.
        let texel = plan.passes.iter().map(|pass| match pass {
            Pass::Casters(pass) => {
                2.0 / (f64::from(pass.viewport.width)
                    * f64::from(pass.view_proj.row(0).truncate().length()))
            }
            _ => 0.0,
        });
        let texel = texel.fold(0.0, f64::max);
        assert!(texel > 0.0 && texel < 0.02, "{method}: {texel} m");
        compare(method, &scene, pixels, texel);
    }
}

/// Each pixel may be off by a share of the steps for each of its shadows' sides, and by what a map blurs them.
fn compare(method: &str, scene: &Scene, pixels: &[[f32; 3]], texel: f64) {
    let Some(Medium {
        scattering,
        anisotropy: g,
        ..
    }) = scene.medium
    else {
        unreachable!("it has a medium")
    };
    let extinction = scene.medium.map_or(0.0, |air| air.extinction());
    let LightKind::Directional { direction: light } = scene.lights[0].light.kind else {
        unreachable!("it has a sun")
    };
    let tracer = Tracer::new(scene).expect("a sound scene");
    let sight = tracer.look(SIZE.0, SIZE.1, &|| ()).expect("a size");
    let view = scene.view(SIZE.0, SIZE.1);
    let (mut sides, mut tightest, mut worst) = (0, f64::INFINITY, 0.0_f64);
    for (pixel, (seen, color)) in (0..).zip(sight.seen().iter().zip(pixels)) {
        let at = DVec2::new(f64::from(pixel % SIZE.0), f64::from(pixel / SIZE.0)) + 0.5;
        let ndc = at / DVec2::new(SIZE.0.into(), SIZE.1.into()) * 2.0 - 1.0;
        let slope = 0.5 * view.projection.size_at(1.0).y;
        let ray = DVec3::new(ndc.x * slope * view.projection.aspect, -ndc.y * slope, -1.0);
        let direction = view.rotation * ray.normalize();
        let begin = view.projection.near * ray.length();
        let end = seen.map_or(view.projection.far * ray.length(), |seen| {
            seen.position.length()
        });
        let lost = 1.0 - (extinction * (begin - end)).exp();
        let is_lit = |step: u32| {
            let share = (f64::from(step) + 0.5) / f64::from(TRUE_STEPS);
            let distance = begin - (1.0 - share * lost).ln() / extinction;
            tracer.arrives(distance * direction, 0).expect("a light")
        };
        let lit: Vec<_> = (0..TRUE_STEPS).map(is_lit).collect();
        let changes = lit.windows(2).filter(|pair| pair[0] != pair[1]).count();
        let share = lit.iter().filter(|lit| **lit).count() as f64 / f64::from(TRUE_STEPS);
        // A side is moved along the ray by more, the less the ray crosses the light.
        let across = direction.cross(light).length();
        let blur = TEXELS * texel / across * extinction / lost;
        let steps = 1.0 / f64::from(TRUE_STEPS) + 1.0 / f64::from(STEPS);
        // The ends are at surfaces, where a bias matters as well.
        let bound = (changes as f64 + 2.0) * (blur + steps);
        let phase =
            (1.0 - g * g) / (4.0 * PI * (1.0 + g * g + 2.0 * g * direction.dot(light)).powf(1.5));
        let found = f64::from(color[0]) / (10.0 * scattering * phase * lost / extinction);
        sides += changes;
        tightest = tightest.min(bound);
        worst = worst.max((found - share).abs() / bound);
        assert!(
            (found - share).abs() <= bound + 2e-3,
            "{method}, pixel {pixel}: {found} of the light, not {share} by {bound}"
        );
    }
    // The bound would let pass anything were there no shafts, or maps of a few texels.
    assert!(
        sides > 500 && tightest < 0.02,
        "{method}: {sides} {tightest} {worst}"
    );
}

//! The figures against closed forms, brute force, and terms made up for the purpose.

mod alias;
mod cause;
mod edges;
mod flip;
mod pool;
mod shimmer;

use glam::{DMat4, DVec3, Vec3};
use umbrage_render::{Object, Scene};
use umbrage_shadow::{
    CasterPass, Cull, DepthOrder, Lens, Light, LightKind, Pass, Rect, ShadowPlan, Viewport,
};

use super::Sample;
use crate::truth::{
    Sight, Tracer,
    tests::stage::{HERE, scene, square},
};

const DOWN: LightKind = LightKind::Directional {
    direction: DVec3::NEG_Y,
};

fn floor() -> Object {
    HERE.object("floor", square(100.0), DVec3::ZERO)
}

/// A floor under a light, seen from `eye`; the middle of the picture is the origin.
fn floor_from(eye: DVec3, light: LightKind) -> Scene {
    scene(
        vec![floor()],
        light,
        HERE.camera(eye, DVec3::ZERO, DVec3::NEG_Z),
    )
}

fn look(scene: &Scene, width: u32, height: u32) -> Sight {
    let tracer = Tracer::new(scene).expect("a sound scene");
    tracer.look(width, height, &|| ()).expect("a size")
}

/// A raster that saw what the rays saw.
fn same(sight: &Sight) -> Vec<Option<(u32, u32)>> {
    let seen = sight.seen().iter();
    seen.map(|seen| seen.map(|seen| (seen.object, seen.triangle)))
        .collect()
}

/// A caster pass into a whole map.
fn pass(resolution: u32, view_proj: DMat4) -> Pass {
    Pass::Casters(CasterPass {
        shader: "caster".to_owned(),
        depth: Some(DepthOrder::Reversed.nearest("map".into())),
        viewport: Viewport {
            x: 0,
            y: 0,
            width: resolution,
            height: resolution,
        },
        cull: Cull::Nothing,
        view_proj: view_proj.as_mat4(),
        casters: Vec::new(),
        colors: Vec::new(),
        constants: umbrage_shadow::Constants::new(),
        receivers: None,
    })
}

fn plan(passes: Vec<Pass>, filter_radius: f64) -> ShadowPlan {
    ShadowPlan {
        passes,
        filter_radius,
        ..ShadowPlan::default()
    }
}

/// A plan of one directional map around the origin, `2 * half` metres wide.
fn sun_plan(scene: &Scene, direction: DVec3, half: f64, resolution: u32) -> ShadowPlan {
    let origin = -scene.camera.position;
    let lens = Lens::directional(direction);
    let (middle, distance) = lens.place(origin);
    let rect = Rect {
        min: middle - half,
        max: middle + half,
    };
    let matrix = lens.matrix(&rect, distance - 50.0, distance + 50.0);
    plan(vec![pass(resolution, matrix)], 1.5)
}

fn light(kind: LightKind) -> Light {
    let color = Vec3::ONE;
    Light { kind, color }
}

/// Terms made up for one light, for a scene that is seen from above.
struct Made {
    scene: Scene,
    sight: Sight,
    truth: Vec<Option<f32>>,
    rendered: Vec<f32>,
    gaps: Vec<Option<f64>>,
    plan: Option<ShadowPlan>,
}

impl Made {
    /// A lit floor, 10 m below the camera.
    fn new(width: u32, height: u32) -> Self {
        let scene = floor_from(DVec3::new(0.0, 10.0, 0.0), DOWN);
        let sight = look(&scene, width, height);
        let pixels = sight.seen().len();
        Self {
            scene,
            sight,
            truth: vec![Some(1.0); pixels],
            rendered: vec![1.0; pixels],
            gaps: vec![None; pixels],
            plan: None,
        }
    }

    fn figures(&self) -> super::Figures {
        self.figures_of(&same(&self.sight))
    }

    fn figures_of(&self, raster: &[Option<(u32, u32)>]) -> super::Figures {
        let sample = Sample {
            light: &self.scene.lights[0].light,
            truth: &self.truth,
            gaps: &self.gaps,
            rendered: &self.rendered,
            plan: self.plan.as_ref(),
        };
        super::figures(&self.scene, &self.sight, raster, &[sample]).expect("of one size")
    }
}

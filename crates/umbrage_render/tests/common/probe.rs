//! A method whose plan and shader a test makes up.
#![allow(dead_code, reason = "each test program uses its own part")]

use std::sync::Arc;

use umbrage_compose::{Composer, Library, Package, Target};
use umbrage_render::{
    Gpu, Picture, RenderError, RenderOptions, Rendered, Renderer, Scene, Shadow, What,
};
use umbrage_shadow::{
    Frame, Light, Part, PlanError, Setting, ShadowMethod, ShadowPlan, Support, TextureDesc,
};
use wgpu::TextureFormat;

use super::{methods, scene, small};

struct Probe(Box<dyn Fn(&Frame<'_>) -> ShadowPlan + Send + Sync>);

const SETTINGS: [Setting; 1] = [Setting {
    name: "which",
    doc: "what the shader tells",
    min: 0.0,
    max: 100.0,
    default: 0.0,
    whole: true,
}];

impl Part for Probe {
    fn name(&self) -> &str {
        "probe"
    }
    fn settings(&self) -> &[Setting] {
        &SETTINGS
    }
    fn axes(&self) -> &[&str] {
        &["pcf"]
    }
}

impl ShadowMethod for Probe {
    fn supports(&self, _: &Light) -> Support {
        Support::Yes
    }
    fn plan(&self, frame: &Frame<'_>) -> Result<ShadowPlan, PlanError> {
        Ok((self.0)(frame))
    }
}

const AXES: &str = r#"(axes: { "method": (values: {
    "probe": (bind: { "umbrage::interface::shadow": "package::probe" }),
}) })"#;

/// A renderer whose method `probe` has this shader and this plan.
pub(crate) fn probing(
    shader: &str,
    plan: impl Fn(&Frame<'_>) -> ShadowPlan + Send + Sync + 'static,
) -> Renderer {
    probing_with(&[("axes.ron", AXES), ("probe.wesl", shader)], plan)
}

/// The same with these files in the package `probe`, its axes among them.
pub(crate) fn probing_with(
    files: &[(&str, &str)],
    plan: impl Fn(&Frame<'_>) -> ShadowPlan + Send + Sync + 'static,
) -> Renderer {
    let files = files.iter();
    let files = files.map(|(path, text)| ((*path).to_owned(), (*text).to_owned()));
    let probe = Package::from_sources("probe", "probe", files).expect("a package");
    let ours = umbrage_shader_lib::package().expect("the shader library");
    let library = Library::new([ours, probe]).expect("the library");
    let composer = Arc::new(Composer::new(library, Target::default()));
    let mut registry = methods();
    registry
        .methods
        .add(Probe(Box::new(plan)))
        .expect("a new one");
    Renderer::new(
        Arc::new(Gpu::new().expect("an adapter")),
        composer,
        registry,
    )
}

/// A wall that the camera sees wherever it looks, 3 m before it, in the sun.
fn wall() -> Scene {
    scene(
        r#"(
        camera: (position: (0, 0, 3), target: (0, 0, 0)),
        lights: [(kind: directional(direction: (0, 0, -1)))],
        models: [(shape: box(size: (20, 20, 1)), translation: (0, 0, -0.5))])"#,
    )
}

fn told(renderer: &mut Renderer, which: f64) -> Result<Rendered, RenderError> {
    let mut options = RenderOptions {
        width: 4,
        height: 4,
        shadow: Shadow::new("probe"),
        ..small(What::ShadowTerm)
    };
    options.shadow.settings.insert("which".to_owned(), which);
    renderer.render(&wall(), &options)
}

/// The shader's answer where its setting `which` is this: the same at every pixel.
pub(crate) fn number(renderer: &mut Renderer, which: f64) -> f32 {
    let rendered = told(renderer, which).expect("renders");
    let Picture::ShadowTerm(lights) = &rendered.picture else {
        unreachable!("a shadow term was asked for")
    };
    let first = lights[0][0];
    assert!(lights[0].iter().all(|term| *term == first), "{lights:?}");
    first
}

pub(crate) fn refusal(renderer: &mut Renderer) -> String {
    told(renderer, 0.0).expect_err("refused").to_string()
}

/// A texture of one rectangle.
pub(crate) fn texture(name: &str, format: TextureFormat, width: u32, height: u32) -> TextureDesc {
    TextureDesc::d2(name, format, [width, height])
}

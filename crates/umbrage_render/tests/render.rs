//! The renderer with scenes, options and methods, good and bad.

mod common;

use std::sync::Arc;

use common::{color, example, methods, renderer, scene, small};
use glam::{DVec3, Vec3, Vec4};
use umbrage_compose::Source;
use umbrage_render::{Picture, RenderOptions, Rendered, Renderer, Scene, Shadow, What};
use umbrage_shadow::{
    CasterPass, Constants, Cull, DepthOrder, DepthTarget, Frame, Light, Part, Pass, PlanError,
    Registry, ShadowMethod, ShadowPlan, Support, TextureDesc, Viewport,
};

/// A ball of either surface on a ground; the far lamp reaches only the ground under it.
fn two_balls() -> Scene {
    scene(
        r#"(
        camera: (position: (0, 3, 8), target: (0, 0, 0)),
        lights: [
            (name: "sun", kind: directional(direction: (0, -1, -1))),
            (name: "lamp", kind: point(position: (-2, 1.2, 0), range: 1)),
            (name: "away", kind: point(position: (0, 0, 90), range: 1)),
        ],
        models: [
            (shape: sphere(radius: 0.5), name: "matt", translation: (-2, 0.5, 0)),
            (shape: sphere(radius: 0.5), name: "shiny", translation: (2, 0.5, 0), surface: "ggx"),
            (shape: sphere(radius: 0.5), name: "unseen", translation: (0, 0, 20), surface: "ggx"),
        ])"#,
    )
}

#[test]
fn what_a_scene_needs_is_composed_and_no_more() {
    let scene = two_balls();
    let mut renderer = renderer(methods());
    let first = renderer
        .render(&scene, &small(What::Shaded))
        .expect("renders");
    let uses: Vec<_> = first
        .report
        .permutations
        .iter()
        .map(|used| {
            let light = used.light.clone().unwrap_or_default();
            format!("{} for {} {light}", used.key, used.object)
        })
        .collect();
    assert_eq!(
        uses,
        [
            "pass=base for matt ",
            "pass=illumination for matt sun",
            "pass=illumination,surface=ggx for shiny sun",
            "light=point,pass=illumination for matt lamp",
        ]
    );
    assert_eq!((first.report.composed(), first.report.cached()), (4, 0));
    // Base, sun and lamp; the light that is away has no pass.
    assert_eq!(first.report.passes, 3);
    assert_eq!(first.report.draws, 5);

    let again = renderer
        .render(&scene, &small(What::Shaded))
        .expect("renders");
    assert_eq!((again.report.composed(), again.report.cached()), (0, 4));
    assert!(
        again
            .report
            .permutations
            .iter()
            .all(|used| used.source == Source::Memory)
    );
    assert_eq!(again.picture, first.picture);
}

#[test]
fn renderers_may_change_threads() {
    fn assert_send<T: Send>() {}
    assert_send::<Renderer>();
}

#[test]
fn objects_that_look_alike_are_one_draw() {
    let ball = |x: i32| format!("(shape: sphere(radius: 0.3), translation: ({x}, 0, 0)),");
    let balls: String = (-3..=3).map(ball).collect();
    let text = format!("(camera: (position: (0, 1, 9), target: (0, 0, 0)), models: [{balls}])");
    let rendered = renderer(methods()).render(&scene(&text), &small(What::Shaded));
    assert_eq!(rendered.expect("renders").report.draws, 1);
}

/// Colours of vertices multiply the material's, in ambient light as in a lamp's.
#[test]
fn colours_of_vertices_tint_their_mesh() {
    let (mut plain, mut tinted) = (two_balls(), two_balls());
    let tint = Vec4::new(0.5, 1.0, 0.25, 1.0);
    for (plain, tinted) in plain.objects.iter_mut().zip(&mut tinted.objects) {
        Arc::make_mut(&mut plain.material).base_color *= tint;
        let mesh = Arc::make_mut(&mut tinted.mesh);
        mesh.colors = vec![tint; mesh.positions.len()];
    }
    (plain.ambient, tinted.ambient) = (Vec3::splat(0.2), Vec3::splat(0.2));
    let mut renderer = renderer(methods());
    let mut colors = |scene: &Scene| match renderer.render(scene, &small(What::Shaded)) {
        Ok(Rendered {
            picture: Picture::Shaded(colors),
            report,
            ..
        }) => (colors, report.permutations),
        other => unreachable!("a shaded picture was asked for: {:?}", other.err()),
    };
    let ((plain, _), (tinted, permutations)) = (colors(&plain), colors(&tinted));
    let tinted_keys = permutations
        .iter()
        .filter(|used| used.key.get("vertex_color") == Some("on"));
    // The base pass; the sun on either surface, and the lamp on one.
    assert_eq!(tinted_keys.count(), 4, "{permutations:?}");
    for (plain, tinted) in plain.iter().zip(tinted) {
        for (plain, tinted) in plain.iter().zip(tinted) {
            // Half floats.
            assert!(
                (plain - tinted).abs() <= 2e-3 * plain.abs(),
                "{plain} {tinted}"
            );
        }
    }
    assert!(
        plain
            .iter()
            .any(|color| color[1] > 3.0 * color[2] && color[1] > 0.3)
    );
}

#[test]
fn lights_of_one_name_keep_their_own_maps() {
    let mut both = example("bunny_sun.ron");
    let mut other = both.lights[0].clone();
    let umbrage_shadow::LightKind::Directional { direction } = &mut other.light.kind else {
        unreachable!("it has a sun")
    };
    direction.x = -direction.x;
    both.lights.push(other.clone());
    let mut alone = both.clone();
    alone.lights = vec![other];
    let mut renderer = renderer(methods());
    let mut terms = |scene: &Scene| {
        let rendered = renderer
            .render(scene, &small(What::ShadowTerm))
            .expect("renders");
        let Picture::ShadowTerm(lights) = rendered.picture else {
            unreachable!("a shadow term was asked for")
        };
        lights
    };
    assert_eq!(terms(&both)[1], terms(&alone)[0]);
    assert_ne!(terms(&both)[0], terms(&both)[1]);
}

#[test]
fn the_same_input_gives_the_same_pixels() {
    let scene = example("leaves.ron");
    for what in [
        What::Shaded,
        What::ShadowTerm,
        What::Triangles,
        What::Fetches,
    ] {
        let render = || {
            renderer(methods())
                .render(&scene, &small(what))
                .expect("renders")
        };
        assert_eq!(render().picture, render().picture);
    }
}

#[test]
fn a_scene_far_from_the_origin_looks_as_it_does_there() {
    let near = example("suzanne_spot.ron");
    let mut far = near.clone();
    // A power of two, so that nothing is rounded on the way.
    let offset = DVec3::new(1_048_576.0, 0.0, -1_048_576.0);
    far.camera.position += offset;
    for object in &mut far.objects {
        object.transform.translation += offset;
        object.bounds = object.bounds.translate(offset);
    }
    for light in &mut far.lights {
        if let umbrage_shadow::LightKind::Spot { position, .. } = &mut light.light.kind {
            *position += offset;
        }
    }
    let mut renderer = renderer(methods());
    let mut shoot = |scene: &Scene| {
        let rendered = renderer
            .render(scene, &small(What::Shaded))
            .expect("renders");
        let Picture::Shaded(pixels) = rendered.picture else {
            unreachable!("a shaded picture was asked for")
        };
        pixels
    };
    let (near, far) = (shoot(&near), shoot(&far));
    let differ = near.iter().zip(&far).filter(|(a, b)| {
        a.iter()
            .zip(b.iter())
            .any(|(a, b)| (a - b).abs() > 0.02 * a.max(*b) + 1e-3)
    });
    // A shadow's edge may fall on the other side of a pixel here and there.
    assert!(differ.count() < near.len() / 1000);
}

#[test]
fn a_cookie_is_projected_upright() {
    let scene = example("suzanne_spot.ron");
    let options = RenderOptions {
        shadow: Shadow::new("none"),
        ..RenderOptions::default()
    };
    let rendered = renderer(methods())
        .render(&scene, &options)
        .expect("renders");
    let [r, g, b] = color(&scene, &rendered, DVec3::new(-2.8, 0.0, -4.1));
    assert!(r > 2.0 * g && r > 2.0 * b, "red top left, not {r} {g} {b}");
    let [r, g, b] = color(&scene, &rendered, DVec3::new(2.8, 0.0, -4.1));
    assert!(g > 2.0 * r && g > b, "green top right, not {r} {g} {b}");
    let [r, g, b] = color(&scene, &rendered, DVec3::new(-1.6, 0.0, 1.5));
    assert!(
        b > 2.0 * r && b > 2.0 * g,
        "blue bottom left, not {r} {g} {b}"
    );
}

#[test]
fn every_axis_can_be_forced() {
    let scene = two_balls();
    let mut renderer = renderer(methods());
    let axes = [
        ("surface", "ggx"),
        ("alpha_test", "on"),
        ("base_color_texture", "on"),
        ("cookie", "on"),
        ("pcf", "7"),
        ("receiver_bias", "constant"),
    ];
    let mut options = small(What::Shaded);
    for (axis, value) in axes {
        options.shadow = options.shadow.with(axis, value);
    }
    let rendered = renderer.render(&scene, &options).expect("renders");
    let keys: Vec<_> = rendered
        .report
        .permutations
        .iter()
        .map(|u| u.key.to_string())
        .collect();
    assert_eq!(
        keys,
        [
            "alpha_test=on,base_color_texture=on,pass=base",
            "alpha_test=on,base_color_texture=on,pass=illumination,surface=ggx",
            "alpha_test=on,base_color_texture=on,light=point,pass=illumination,surface=ggx",
        ]
    );
}

#[test]
fn options_that_cannot_be_met_are_refused() {
    let mut renderer = renderer(methods());
    let mut refuse = |scene: &Scene, change: &dyn Fn(&mut RenderOptions)| {
        let mut options = small(What::Shaded);
        change(&mut options);
        renderer
            .render(scene, &options)
            .expect_err("refused")
            .to_string()
    };
    let choose = |axis: &str, value: &str| {
        let (axis, value) = (axis.to_owned(), value.to_owned());
        move |options: &mut RenderOptions| {
            options.shadow.axes.insert(axis.clone(), value.clone());
        }
    };
    let good = two_balls();
    assert!(refuse(&good, &|o| o.width = 0).contains("0 by 120 pixels"));
    assert!(refuse(&good, &|o| o.height = 1 << 20).contains("160 by 1048576 pixels"));
    let message = refuse(&good, &|o| o.shadow = Shadow::new("basik"));
    assert!(
        message.contains("light `sun`") && message.contains("did you mean `basic`"),
        "{message}"
    );
    let message = refuse(&good, &choose("surfaces", "ggx"));
    assert!(
        message.contains("no axis of that name") && message.contains("`surface`"),
        "{message}"
    );
    assert!(refuse(&good, &choose("surface", "glass")).contains("ggx, lambert"));
    assert!(refuse(&good, &choose("method", "basic")).contains("follows from the scene"));

    let shadow = |text: &str| {
        scene(&format!(
            r#"(camera: (position: (0, 3, 8), target: (0, 0, 0)),
            lights: [(name: "sun", kind: directional(direction: (0, -1, 0)), shadow: {text})],
            models: [(shape: plane(size: (2, 2)), surface: "lambert")])"#
        ))
    };
    let cases = [
        (r#"(method: "vsm")"#, "light `sun`: no shadow method `vsm`"),
        (
            r#"(method: "basic", axes: {"reciever_bias": "plane"})"#,
            "did you mean `receiver_bias`?",
        ),
        (
            r#"(method: "basic", axes: {"surface": "ggx"})"#,
            "method `basic` has no axis",
        ),
        (
            r#"(method: "basic", axes: {"pcf": "4"})"#,
            "axis `pcf` has no value `4` (known: 1, 11,",
        ),
        (
            r#"(method: "basic", settings: {"resolution": -1})"#,
            "method `basic`: `resolution` is -1",
        ),
        (
            r#"(method: "basic", settings: {"size": 1})"#,
            "no setting `size`",
        ),
    ];
    for (text, expected) in cases {
        let message = refuse(&shadow(text), &|_| ());
        assert!(message.contains(expected), "{message}\nlacks: {expected}");
    }
    let mut scene = two_balls();
    let mut material = (*scene.objects[0].material).clone();
    material.surface = "velvet".to_owned();
    scene.objects[0].material = material.into();
    assert!(refuse(&scene, &|_| ()).contains("velvet"));
    let mut mesh = (*scene.objects[1].mesh).clone();
    mesh.indices[7] = 1 << 30;
    let mut scene = two_balls();
    scene.objects[1].mesh = mesh.into();
    assert!(refuse(&scene, &|_| ()).contains("its indices do not fit"));
    let mut scene = two_balls();
    scene.camera.position.x = f64::NAN;
    assert!(refuse(&scene, &|_| ()).contains("the camera: the view's position"));
    let mut scene = two_balls();
    scene.objects[1].bounds.min.x = f64::INFINITY;
    assert!(refuse(&scene, &|_| ()).contains("object `shiny`: its box"));
    // A fault leaves the renderer as good as new.
    assert!(renderer.render(&good, &small(What::Shaded)).is_ok());
}

/// Stands in for the method `basic`, with a plan that is at fault.
struct Faulty(Fault);

type Fault = fn(&mut ShadowPlan);

impl Part for Faulty {
    fn name(&self) -> &str {
        "basic"
    }
}

impl ShadowMethod for Faulty {
    fn supports(&self, light: &Light) -> Support {
        match light.kind {
            umbrage_shadow::LightKind::Point { .. } => Support::No("it has no sides".to_owned()),
            _ => Support::Yes,
        }
    }
    fn plan(&self, frame: &Frame<'_>) -> Result<ShadowPlan, PlanError> {
        let mut plan = ShadowPlan {
            textures: vec![TextureDesc::d2(
                "shadow_map",
                wgpu::TextureFormat::Depth32Float,
                [64; 2],
            )],
            passes: vec![Pass::Casters(CasterPass {
                shader: "caster".to_owned(),
                depth: Some(DepthOrder::Reversed.nearest("shadow_map".into())),
                viewport: Viewport {
                    x: 0,
                    y: 0,
                    width: 64,
                    height: 64,
                },
                cull: Cull::Nothing,
                view_proj: glam::Mat4::IDENTITY,
                constants: Constants::new(),
                casters: (0..frame.casters.casters.len()).collect(),
                colors: Vec::new(),
                receivers: None,
            })],
            constants: Constants::new(),
            ..ShadowPlan::default()
        };
        (self.0)(&mut plan);
        Ok(plan)
    }
}

fn pass(plan: &mut ShadowPlan) -> &mut CasterPass {
    let Some(Pass::Casters(pass)) = plan.passes.first_mut() else {
        unreachable!("the plan has a pass")
    };
    pass
}

fn depth(plan: &mut ShadowPlan) -> &mut DepthTarget {
    pass(plan).depth.as_mut().expect("it draws depth")
}

#[test]
fn faulty_methods_are_named() {
    let scene = two_balls();
    let refuse = |fault: Fault, what: usize| {
        let mut registry = Registry::new();
        registry.methods.add(Faulty(fault)).expect("the only one");
        let mut scene = scene.clone();
        scene.lights = vec![scene.lights[what].clone()];
        let mut options = small(What::Shaded);
        options.shadow = Shadow::new("basic");
        renderer(registry)
            .render(&scene, &options)
            .expect_err("refused")
            .to_string()
    };
    let cases: [(Fault, &str); 9] = [
        (|plan| depth(plan).target = "map".into(), "the target `map`"),
        (
            |plan| depth(plan).target.layer = 1,
            "layer 1 of `shadow_map`",
        ),
        (
            |plan| pass(plan).viewport.x = 1,
            "outside the 64 by 64 texels",
        ),
        (
            |plan| pass(plan).viewport.width = u32::MAX,
            "outside the 64 by 64 texels",
        ),
        (
            |plan| pass(plan).casters = vec![3],
            "a caster that there is not",
        ),
        (|plan| pass(plan).depth = None, "casters into no texture"),
        (
            |plan| pass(plan).view_proj.x_axis.x = f32::NAN,
            "not finite",
        ),
        (
            |plan| plan.textures[0].format = wgpu::TextureFormat::R32Float,
            "not of depth alone",
        ),
        (|plan| plan.textures[0].width = 0, "0 by 64 texels"),
    ];
    for (fault, expected) in cases {
        let message = refuse(fault, 0);
        assert!(message.contains(expected), "{message}\nlacks: {expected}");
    }
    // The plan is sound, but says nothing of the constants and the sampler that its shader reads.
    let message = refuse(|_| (), 0);
    assert!(
        message.contains("`shadow_sampler` of umbrage::depths::nearest"),
        "{message}"
    );
    let message = refuse(|_| (), 1);
    assert!(
        message.contains("cannot shadow light `lamp`: it has no sides"),
        "{message}"
    );
}

//! Passes that compute something from shadow maps.

mod common;

use common::probe::{number, probing_with, refusal, texture};
use glam::{Mat4, Vec3};
use umbrage_shadow::{
    Blend, BufferContents, BufferDesc, CasterPass, ColorTarget, ComputePass, Constants, Cull,
    DepthOrder, Frame, Need, Pass, Reads, ScreenPass, ShadowPlan, Value, Viewport,
};
use wgpu::{ColorWrites, TextureFormat};

/// Texels along the maps.
const SIZE: u32 = 8;

const AXES: &str = r#"(axes: {
    "method": (values: {
        "probe": (bind: { "umbrage::interface::shadow": "package::probe" }),
    }),
    "pass": (values: {
        "probe_scale": (root: "package::scale"),
        "probe_deepen": (root: "package::deepen"),
        "probe_mirror": (root: "package::mirror"),
        "probe_faces": (root: "package::faces"),
    }),
})"#;

/// Tells a texel: `which` is 10 · column + the texture's number, at row 3.
const PROBE: &str = r#"
struct Probe { which: u32 }
@group(1) @binding(0) var<uniform> probe: Probe;
@group(1) @binding(1) var map: texture_depth_2d;
@group(1) @binding(2) var scaled: texture_2d<f32>;
@group(1) @binding(3) var twice_scaled: texture_2d<f32>;
@group(1) @binding(4) var deepened: texture_depth_2d;
@group(1) @binding(5) var mirrored: texture_2d<f32>;
fn calc_shadow(position_ws: vec3f) -> f32 {
    let texel = vec2u(probe.which / 10u, 3u);
    switch probe.which % 10u {
        case 0u { return textureLoad(map, texel, 0); }
        case 1u { return textureLoad(scaled, texel, 0).r; }
        case 2u { return textureLoad(twice_scaled, texel, 0).r; }
        case 3u { return textureLoad(deepened, texel, 0); }
        case 4u { return textureLoad(mirrored, texel, 0).r; }
        default { return 0.0; }
    }
}
"#;

/// From `before`, by a factor of the pass's own, into a colour.
const SCALE: &str = r#"
struct Scale { factor: f32 }
@group(1) @binding(0) var<uniform> scale: Scale;
@group(1) @binding(1) var before: texture_2d<f32>;
@vertex fn vs_scale(@builtin(vertex_index) number: u32) -> @builtin(position) vec4f {
    return vec4f(4.0 * vec2f(f32(number & 1), f32(number >> 1)) - 1.0, 0.0, 1.0);
}
@fragment fn fs_scale(@builtin(position) clip: vec4f) -> @location(0) f32 {
    return scale.factor * textureLoad(before, vec2u(clip.xy), 0).r;
}
"#;

/// Half of the depth of `map`, as a depth.
const DEEPEN: &str = r#"
@group(1) @binding(1) var map: texture_depth_2d;
@vertex fn vs_deepen(@builtin(vertex_index) number: u32) -> @builtin(position) vec4f {
    return vec4f(4.0 * vec2f(f32(number & 1), f32(number >> 1)) - 1.0, 0.0, 1.0);
}
@fragment fn fs_deepen(@builtin(position) clip: vec4f) -> @builtin(frag_depth) f32 {
    return 0.5 * textureLoad(map, vec2u(clip.xy), 0);
}
"#;

/// `map`, its columns from the right, by way of a workgroup's memory.
const MIRROR: &str = r#"
@group(1) @binding(1) var map: texture_depth_2d;
@group(1) @binding(2) var mirrored: texture_storage_2d<r32float, write>;
var<workgroup> row: array<f32, 8>;
@compute @workgroup_size(8, 1) fn cs_mirror(@builtin(local_invocation_index) x: u32, @builtin(workgroup_id) group: vec3u) {
    row[x] = textureLoad(map, vec2u(x, group.y), 0);
    workgroupBarrier();
    textureStore(mirrored, vec2u(x, group.y), vec4f(row[7u - x]));
}
"#;

fn everything() -> Viewport {
    Viewport {
        x: 0,
        y: 0,
        width: SIZE,
        height: SIZE,
    }
}

/// A wall at `depth` in the columns from `x`.
fn casters(x: u32, depth: f32) -> CasterPass {
    let scale = Mat4::from_scale(Vec3::new(0.2, 0.2, 0.01));
    CasterPass {
        shader: "caster".to_owned(),
        depth: Some(DepthOrder::Reversed.nearest("map".into())),
        colors: Vec::new(),
        viewport: Viewport {
            x,
            width: SIZE - x,
            ..everything()
        },
        cull: Cull::Nothing,
        // The wall is 3 m before the camera.
        view_proj: Mat4::from_translation(Vec3::new(0.0, 0.0, depth + 0.03)) * scale,
        constants: Constants::new(),
        casters: vec![0],
        receivers: None,
    }
}

fn scale(from: &str, target: &str, factor: f32) -> Pass {
    Pass::Screen(ScreenPass {
        shader: "probe_scale".to_owned(),
        targets: vec![target.into()],
        viewport: everything(),
        reads: Reads {
            renamed: vec![("before".to_owned(), from.into())],
            constants: Constants::new().with("factor", Value::F32(factor)),
        },
    })
}

fn mirror() -> ComputePass {
    ComputePass {
        shader: "probe_mirror".to_owned(),
        workgroups: [1, SIZE, 1].into(),
        writes: vec!["mirrored".into()],
        reads: Reads::default(),
    }
}

/// A wall in the right half, from which all else is computed.
fn plan(frame: &Frame<'_>) -> ShadowPlan {
    let map = |name: &str, format| texture(name, format, SIZE, SIZE);
    ShadowPlan {
        textures: vec![
            map("map", TextureFormat::Depth32Float),
            map("deepened", TextureFormat::Depth32Float),
            map("mirrored", TextureFormat::R32Float),
            map("scaled", TextureFormat::R32Float),
            map("twice_scaled", TextureFormat::R16Float),
        ],
        passes: vec![
            Pass::Casters(casters(SIZE / 2, 0.5)),
            Pass::Screen(ScreenPass {
                shader: "probe_deepen".to_owned(),
                targets: vec!["deepened".into()],
                viewport: Viewport {
                    x: 6,
                    width: 2,
                    ..everything()
                },
                reads: Reads::default(),
            }),
            Pass::Compute(mirror()),
            scale("mirrored", "scaled", 0.5),
            scale("scaled", "twice_scaled", 0.25),
        ],
        constants: Constants::new().with("which", Value::U32(frame.settings.get("which") as u32)),
        ..ShadowPlan::default()
    }
}

const FILES: [(&str, &str); 5] = [
    ("axes.ron", AXES),
    ("probe.wesl", PROBE),
    ("scale.wesl", SCALE),
    ("deepen.wesl", DEEPEN),
    ("mirror.wesl", MIRROR),
];

/// With a shader that tells the side of a wall in red or green.
fn files() -> Vec<(&'static str, &'static str)> {
    FILES.into_iter().chain([("faces.wesl", FACES)]).collect()
}

#[test]
fn passes_work_from_what_those_before_them_left() {
    let mut renderer = probing_with(&files(), plan);
    let mut at = |column: u32, map: u32| number(&mut renderer, f64::from(10 * column + map));
    let row = |at: &mut dyn FnMut(u32, u32) -> f32, map| [1, 5, 7].map(|column| at(column, map));
    let [left, wall, same] = row(&mut at, 0);
    assert!(
        left == 0.0 && wall == same && (wall - 0.5).abs() < 1e-6,
        "{wall}"
    );
    assert_eq!(row(&mut at, 4), [wall, 0.0, 0.0], "mirrored");
    assert_eq!(row(&mut at, 1), [0.5 * wall, 0.0, 0.0], "scaled");
    // In halves of a float.
    assert_eq!(row(&mut at, 2)[1..], [0.0, 0.0], "scaled again");
    assert!((at(1, 2) - 0.125 * wall).abs() < 1e-4);
    // Only two columns were filled; the rest is cleared.
    assert_eq!(row(&mut at, 3), [0.0, 0.0, 0.5 * wall], "deepened");
}

/// A shadow term may be read from what a pass wrote into a buffer, which stands.
#[test]
fn a_buffer_that_a_pass_wrote_is_shaded_by() {
    const WRITE: &str = r#"
struct Term { first: u32, rest: array<f32, 3> }
@group(0) @binding(0) var<storage, read_write> term: Term;
@compute @workgroup_size(3) fn cs(@builtin(global_invocation_id) id: vec3u) {
    term.first = 5u;
    term.rest[id.x] = 0.25 * f32(id.x);
}
"#;
    const READ: &str = r#"
struct Term { first: u32, rest: array<f32, 3> }
struct Probe { which: u32 }
@group(1) @binding(0) var<uniform> probe: Probe;
@group(1) @binding(1) var<storage, read> term: Term;
fn calc_shadow(position_ws: vec3f) -> f32 {
    return f32(term.first) + term.rest[probe.which];
}
"#;
    const AXES: &str = r#"(axes: {
        "method": (values: { "probe": (bind: { "umbrage::interface::shadow": "package::probe" }) }),
        "pass": (values: { "probe_write": (root: "package::write") }),
    })"#;
    let files = [
        ("axes.ron", AXES),
        ("write.wesl", WRITE),
        ("probe.wesl", READ),
    ];
    let mut renderer = probing_with(&files, |frame| {
        let which = frame.settings.get("which") as u32;
        ShadowPlan {
            buffers: vec![BufferDesc {
                name: "term".to_owned(),
                contents: BufferContents::Written(16),
            }],
            passes: vec![Pass::Compute(ComputePass {
                shader: "probe_write".to_owned(),
                workgroups: [1; 3].into(),
                writes: vec!["term".into()],
                reads: Reads::default(),
            })],
            constants: Constants::new().with("which", Value::U32(which)),
            ..ShadowPlan::default()
        }
    });
    for (which, term) in [(0.0, 5.0), (1.0, 5.25), (2.0, 5.5)] {
        assert_eq!(number(&mut renderer, which), term);
    }
}

/// Depth in red for faces that are turned to the light, in green for others.
const FACES: &str = r#"
import umbrage::common::frame::{drawn, frame, instances};
@vertex fn vs_faces(@builtin(instance_index) instance: u32, @location(0) position: vec3f) -> @builtin(position) vec4f {
    return frame.view_proj * (instances[drawn[instance]].model * vec4f(position, 1.0));
}
@fragment fn fs_faces(@builtin(position) clip: vec4f, @builtin(front_facing) front: bool) -> @location(0) vec2f {
    return select(vec2f(0.0, clip.z), vec2f(clip.z, 0.0), front);
}
"#;

/// A plan of one pass without depth that keeps the larger one of each channel.
fn faces(frame: &Frame<'_>) -> ShadowPlan {
    let mut plan = plan(frame);
    plan.textures[3].format = TextureFormat::Rg32Float;
    let mut pass = casters(0, 0.5);
    pass.shader = "probe_faces".to_owned();
    pass.depth = None;
    pass.colors = vec![ColorTarget {
        target: "scaled".into(),
        channels: ColorWrites::RED | ColorWrites::GREEN,
        blend: Blend::Max,
    }];
    plan.passes = vec![Pass::Casters(pass)];
    plan.needs = vec![Need {
        features: wgpu::Features::FLOAT32_BLENDABLE,
        instead: "another test".to_owned(),
    }];
    plan
}

#[test]
fn the_larger_one_is_kept_without_a_depth_texture() {
    let mut renderer = probing_with(&files(), faces);
    // The box's front is the nearest that is turned to the camera, whatever was drawn last.
    assert!((number(&mut renderer, 41.0) - 0.5).abs() < 1e-6);
}

#[test]
fn what_the_device_lacks_is_named_with_what_to_choose() {
    let mut renderer = probing_with(&files(), |frame| {
        let mut plan = faces(frame);
        // Nothing of ours ever asks for it.
        plan.needs[0].features |= wgpu::Features::MULTIVIEW;
        plan
    });
    let said = refusal(&mut renderer);
    assert!(said.contains("needs multiview, which"), "{said}");
    assert!(said.ends_with("choose another test"), "{said}");
}

#[test]
fn passes_that_cannot_run_are_named() {
    type Spoil = fn(&mut ShadowPlan);
    fn screen(plan: &mut ShadowPlan) -> &mut ScreenPass {
        let Pass::Screen(pass) = &mut plan.passes[1] else {
            unreachable!("it is a full-screen pass")
        };
        pass
    }
    fn compute(plan: &mut ShadowPlan) -> &mut ComputePass {
        let Pass::Compute(pass) = &mut plan.passes[2] else {
            unreachable!("it is a compute pass")
        };
        pass
    }
    let cases: [(Spoil, &str); 8] = [
        (
            |plan| screen(plan).targets = vec!["gone".into()],
            "the target `gone`, which is none of its textures",
        ),
        (
            |plan| screen(plan).viewport.x = SIZE,
            "outside the 8 by 8 texels of `deepened`",
        ),
        (
            |plan| plan.textures[1].format = TextureFormat::Rgba32Uint,
            "a colour into `deepened`, which is not of floats (Rgba32Uint)",
        ),
        (
            |plan| screen(plan).shader = "probe_gone".to_owned(),
            "probe_gone",
        ),
        (
            |plan| compute(plan).workgroups = [1, 0, 1].into(),
            "[1, 0, 1] workgroups of `probe_mirror`, where the device allows from 1 to",
        ),
        (
            |plan| compute(plan).writes.clear(),
            "`probe_mirror` stores to `mirrored`, which is not among what it `writes`",
        ),
        (
            |plan| compute(plan).writes = vec!["gone".into()],
            "the target `gone`, which is none of its textures",
        ),
        (
            |plan| plan.textures[2].format = TextureFormat::Rgba8UnormSrgb,
            "the texture `mirrored` is written by a compute shader",
        ),
    ];
    for (spoil, expected) in cases {
        let mut renderer = probing_with(&files(), move |frame| {
            let mut plan = plan(frame);
            spoil(&mut plan);
            plan
        });
        let said = refusal(&mut renderer);
        assert!(said.contains(expected), "{expected}: {said}");
    }
}

//! Layers, mip levels, several colours at once, depth orders, and workgroups that the device counts.

mod common;

use common::{Lab, words};
use glam::{Mat4, Vec2};
use umbrage_shadow::{
    Answers, Blend, BufferContents, BufferDesc, CasterPass, ColorTarget, ComputePass, Constants,
    Cull, DepthOrder, DepthTarget, Pass, Reads, ScreenPass, ShadowPlan, Slice, Source, TextureDesc,
    TextureShape, Value, Viewport, Workgroups,
};
use umbrage_wgpu::Run;
use wgpu::{ColorWrites, TextureFormat as Format};

/// Each texel's place, from 0 on, times a factor.
const FILL: &str = r#"
struct Fill { factor: f32 }
@group(0) @binding(0) var<uniform> fill: Fill;
@vertex fn vs(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {
    return vec4f(4.0 * vec2f(f32(i & 1), f32(i >> 1)) - 1.0, 0.0, 1.0);
}
@fragment fn fs(@builtin(position) at: vec4f) -> @location(0) f32 {
    return fill.factor * (floor(at.x) + 4.0 * floor(at.y));
}
"#;

/// The sum of four texels of a level.
const HALVE: &str = r#"
@group(0) @binding(0) var finer: texture_2d<f32>;
@vertex fn vs(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {
    return vec4f(4.0 * vec2f(f32(i & 1), f32(i >> 1)) - 1.0, 0.0, 1.0);
}
@fragment fn fs(@builtin(position) at: vec4f) -> @location(0) f32 {
    let first = 2u * vec2u(at.xy);
    var sum = 0.0;
    for (var i = 0u; i < 4u; i++) {
        sum += textureLoad(finer, first + vec2u(i & 1u, i >> 1u), 0).x;
    }
    return sum;
}
"#;

/// The same by a compute shader, of a level of two texels a side.
const STORE: &str = r#"
@group(0) @binding(0) var finer: texture_2d<f32>;
@group(0) @binding(1) var coarser: texture_storage_2d<r32float, write>;
@compute @workgroup_size(1) fn cs() {
    var sum = 0.0;
    for (var i = 0u; i < 4u; i++) {
        sum += textureLoad(finer, vec2u(i & 1u, i >> 1u), 0).x;
    }
    textureStore(coarser, vec2u(), vec4f(sum));
}
"#;

/// All texels of all levels of a texture of four texels a side.
const LEVELS: &str = r#"
@group(0) @binding(0) var pyramid: texture_2d<f32>;
@group(0) @binding(1) var<storage, read_write> found: array<f32>;
@compute @workgroup_size(1) fn cs() {
    var n = 0u;
    for (var level = 0u; level < textureNumLevels(pyramid); level++) {
        let side = 4u >> level;
        for (var i = 0u; i < side * side; i++) {
            found[n] = textureLoad(pyramid, vec2u(i % side, i / side), level).x;
            n++;
        }
    }
}
"#;

fn all(side: u32) -> Viewport {
    Viewport::square(side)
}

fn level(level: u32) -> Slice {
    Slice {
        level,
        ..Slice::from("pyramid")
    }
}

fn reads(binding: &str, source: Source) -> Reads {
    Reads {
        renamed: vec![(binding.to_owned(), source)],
        constants: Constants::new(),
    }
}

fn written(name: &str, words: u64) -> BufferDesc {
    BufferDesc {
        name: name.to_owned(),
        contents: BufferContents::Written(4 * words),
    }
}

fn compute(shader: &str, writes: &[Source], reads: Reads) -> ComputePass {
    ComputePass {
        shader: shader.to_owned(),
        workgroups: [1; 3].into(),
        writes: writes.to_vec(),
        reads,
    }
}

/// A pyramid: level 0 is filled, each other one made of the level before it, the last by a compute shader.
fn pyramid(factor: f32) -> ShadowPlan {
    let constants = Constants::new().with("factor", factor);
    let halve = Pass::Screen(ScreenPass {
        shader: "halve".to_owned(),
        targets: vec![level(1)],
        viewport: all(2),
        reads: reads("finer", Source::level("pyramid", 0)),
    });
    let mut store = compute(
        "store",
        &[Source::level("pyramid", 2)],
        reads("finer", Source::level("pyramid", 1)),
    );
    let coarser = ("coarser".to_owned(), Source::level("pyramid", 2));
    store.reads.renamed.push(coarser);
    let found = [Source::from("found")];
    ShadowPlan {
        textures: vec![TextureDesc {
            levels: 3,
            ..TextureDesc::d2("pyramid", Format::R32Float, [4, 4])
        }],
        buffers: vec![written("found", 21)],
        passes: vec![
            Pass::Screen(ScreenPass::new("fill", "pyramid", all(4), constants)),
            halve,
            Pass::Compute(store),
            Pass::Compute(compute("levels", &found, Reads::default())),
        ],
        asks: vec!["found".to_owned()],
        ..ShadowPlan::default()
    }
}

const PYRAMID: [(&str, &str); 4] = [
    ("fill", FILL),
    ("halve", HALVE),
    ("store", STORE),
    ("levels", LEVELS),
];

/// The levels of a pyramid over 0 to 15, times a factor.
fn levels(factor: f32) -> Vec<f32> {
    let mut all: Vec<f32> = (0..16).map(|n| factor * n as f32).collect();
    let block = |corner: usize| [0, 1, 4, 5].map(|n| all[corner + n]).iter().sum::<f32>();
    let second = [0, 2, 8, 10].map(block);
    all.extend(second);
    all.push(second.iter().sum());
    all
}

fn floats(words: &[u32]) -> Vec<f32> {
    words.iter().copied().map(f32::from_bits).collect()
}

#[test]
fn a_level_is_made_of_the_one_before_it() {
    let mut lab = Lab::new(&PYRAMID, |_| pyramid(1.0));
    assert_eq!(floats(&lab.words(0, "found")), levels(1.0));
    // All of it is made of level 0.
    lab.plan_by(|_| pyramid(3.0));
    let done = lab.shadow(0, Answers::none()).expect("executed");
    assert_eq!(done.runs, [Run::Recorded; 4]);
    let answers = lab.answer(&done.question.expect("a question"));
    assert_eq!(floats(&words(&answers, "found")), levels(3.0));
    // Another pass into level 1 leaves level 0 as it stands.
    lab.plan_by(|_| {
        let mut plan = pyramid(3.0);
        let constants = Constants::new().with("factor", 1.0);
        let mut fill = ScreenPass::new("fill", "pyramid", all(2), constants);
        fill.targets = vec![level(1)];
        plan.passes[1] = Pass::Screen(fill);
        plan
    });
    let done = lab.shadow(0, Answers::none()).expect("executed");
    let (kept, recorded) = (Run::Kept, Run::Recorded);
    assert_eq!(done.runs, [kept, recorded, recorded, recorded]);
    let answers = lab.answer(&done.question.expect("a question"));
    let found = floats(&words(&answers, "found"));
    assert_eq!(found[..16], levels(3.0)[..16]);
    assert_eq!(found[16..], [0.0, 1.0, 4.0, 5.0, 10.0]);
}

/// Casters of a flat depth, in two colours of their own: the numbers of the pass, and the depth of the matrix.
const PAINT: &str = r#"
struct Frame { view_proj: mat4x4f }
struct Paint { red: f32, rest: vec2f }
@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> paint: Paint;
@vertex fn vs(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {
    let corner = 4.0 * vec2f(f32(i & 1), f32(i >> 1)) - 1.0;
    return vec4f(corner, frame.view_proj[3].z, 1.0);
}
struct Colors { @location(0) red: f32, @location(1) rest: vec2f }
@fragment fn fs() -> Colors {
    return Colors(paint.red, paint.rest);
}
"#;

/// The first texel of each layer: as an array, one layer by itself, and as a cube's face.
const LAYERS: &str = r#"
@group(0) @binding(0) var reds: texture_2d_array<f32>;
@group(0) @binding(1) var rests: texture_2d_array<f32>;
@group(0) @binding(2) var depths: texture_depth_cube;
@group(0) @binding(3) var depths_sampler: sampler;
@group(0) @binding(4) var one: texture_2d<f32>;
@group(0) @binding(5) var<storage, read_write> found: array<f32>;
@compute @workgroup_size(1) fn cs() {
    for (var i = 0u; i < 6u; i++) {
        found[4u * i] = textureLoad(reds, vec2u(), i, 0).x;
        let rest = textureLoad(rests, vec2u(), i, 0).xy;
        found[4u * i + 1u] = rest.x;
        found[4u * i + 2u] = rest.y;
        var to = vec3f();
        to[i / 2u] = select(-1.0, 1.0, i % 2u == 0u);
        found[4u * i + 3u] = textureSampleLevel(depths, depths_sampler, to, 0u);
    }
    found[24] = textureLoad(one, vec2u(), 0).x;
    found[25] = f32(textureNumLayers(reds));
}
"#;

fn depth(z: f32) -> Mat4 {
    Mat4::from_translation(glam::Vec3::Z * z)
}

fn color(texture: &str, layer: u32, channels: ColorWrites) -> ColorTarget {
    ColorTarget {
        target: Slice::new(texture, layer),
        channels,
        blend: Blend::Replace,
    }
}

fn paint(layer: u32) -> CasterPass {
    let number = layer as f32;
    CasterPass {
        shader: "paint".to_owned(),
        depth: Some(DepthOrder::Reversed.nearest(Slice::new("depths", layer))),
        colors: vec![
            color("reds", layer, ColorWrites::RED),
            color("rests", layer, ColorWrites::RED | ColorWrites::GREEN),
        ],
        viewport: all(2),
        cull: Cull::Nothing,
        view_proj: depth(0.125 * (number + 1.0)),
        constants: Constants::new()
            .with("red", number)
            .with("rest", Vec2::new(10.0 + number, -number)),
        casters: vec![0],
        receivers: None,
    }
}

fn layers() -> ShadowPlan {
    let texture = |name, format, shape| TextureDesc {
        shape,
        ..TextureDesc::d2(name, format, [2, 2])
    };
    let mut passes: Vec<_> = (0..6).map(|layer| Pass::Casters(paint(layer))).collect();
    let one = Source {
        layer: Some(4),
        .."reds".into()
    };
    let found = [Source::from("found")];
    passes.push(Pass::Compute(compute("layers", &found, reads("one", one))));
    ShadowPlan {
        textures: vec![
            texture("reds", Format::R32Float, TextureShape::Array(6)),
            texture("rests", Format::Rg16Float, TextureShape::Array(6)),
            texture("depths", Format::Depth32Float, TextureShape::Cube),
        ],
        samplers: vec![umbrage_shadow::SamplerDesc::new(
            "depths_sampler",
            wgpu::FilterMode::Nearest,
        )],
        buffers: vec![written("found", 26)],
        passes,
        asks: vec!["found".to_owned()],
        ..ShadowPlan::default()
    }
}

#[test]
fn layers_are_drawn_into_in_several_colours() {
    let mut lab = Lab::new(&[("paint", PAINT), ("layers", LAYERS)], |_| layers());
    let found = floats(&lab.words(0, "found"));
    for (layer, found) in found[..24].chunks(4).enumerate() {
        let number = layer as f32;
        let expected = [number, 10.0 + number, -number, 0.125 * (number + 1.0)];
        assert_eq!(found, expected, "layer {layer}");
    }
    assert_eq!(found[24..], [4.0, 6.0]);
    // A pass with other constants is another one; its layer is drawn again, and no other.
    lab.plan_by(|_| {
        let mut plan = layers();
        let mut other = paint(2);
        other.constants = other.constants.with("red", 7.0);
        other.constants = Constants::new()
            .with("red", 7.0)
            .with("rest", Vec2::new(12.0, -2.0));
        plan.passes[2] = Pass::Casters(other);
        plan
    });
    let done = lab.shadow(0, Answers::none()).expect("executed");
    let mut runs = [Run::Kept; 7];
    [runs[2], runs[6]] = [Run::Recorded; 2];
    assert_eq!(done.runs, runs);
    let answers = lab.answer(&done.question.expect("a question"));
    assert_eq!(floats(&words(&answers, "found"))[8], 7.0);
}

/// A depth as bits, where casters are and where none are.
const DEPTHS: &str = r#"
@group(0) @binding(0) var map: texture_depth_2d;
@group(0) @binding(1) var<storage, read_write> found: array<f32>;
@compute @workgroup_size(1) fn cs() {
    found[0] = textureLoad(map, vec2u(0, 0), 0);
    found[1] = textureLoad(map, vec2u(3, 3), 0);
}
"#;

/// Nearest is what the map's order says, and so is empty.
#[test]
fn the_nearest_depth_is_the_order_s() {
    let plan = |order: DepthOrder| {
        let caster = |z: f32, clears: bool| {
            Pass::Casters(CasterPass {
                depth: Some(DepthTarget {
                    clears,
                    ..order.nearest("map".into())
                }),
                colors: Vec::new(),
                viewport: all(2),
                view_proj: depth(z),
                shader: "flat".to_owned(),
                ..paint(0)
            })
        };
        let found = [Source::from("found")];
        ShadowPlan {
            textures: vec![TextureDesc {
                empty: order.empty(),
                ..TextureDesc::d2("map", Format::Depth32Float, [4, 4])
            }],
            buffers: vec![written("found", 2)],
            passes: vec![
                // Gone with the pass that clears.
                caster(0.9375, false),
                caster(0.0625, false),
                caster(0.75, true),
                caster(0.25, false),
                caster(0.5, false),
                Pass::Compute(compute("depths", &found, Reads::default())),
            ],
            asks: vec!["found".to_owned()],
            ..ShadowPlan::default()
        }
    };
    let flat = PAINT.split("struct Colors").next().expect("a vertex stage");
    let passes = [("flat", flat), ("depths", DEPTHS)];
    let mut lab = Lab::new(&passes, move |_| plan(DepthOrder::Reversed));
    assert_eq!(floats(&lab.words(0, "found")), [0.75, 0.0]);
    lab.plan_by(move |_| plan(DepthOrder::Forward));
    assert_eq!(floats(&lab.words(0, "found")), [0.25, 1.0]);
}

/// How many workgroups the next pass has: in the second to fourth word.
const COUNT: &str = r#"
struct Count { across: u32 }
@group(0) @binding(0) var<uniform> own: Count;
@group(0) @binding(1) var<storage, read_write> groups: array<u32>;
@compute @workgroup_size(1) fn cs() {
    groups[1] = own.across;
    groups[2] = 2u;
    groups[3] = 1u;
}
"#;

/// Counts its workgroups.
const GROUPS: &str = r#"
@group(0) @binding(0) var<storage, read_write> found: array<atomic<u32>>;
@compute @workgroup_size(1) fn cs() {
    atomicAdd(&found[0], 1u);
}
"#;

fn counted(across: u32) -> ShadowPlan {
    let constants = Constants::new().with("across", Value::U32(across));
    let reads = Reads {
        constants,
        ..Reads::default()
    };
    let mut groups = compute("groups", &["found".into()], Reads::default());
    groups.workgroups = Workgroups::Indirect {
        buffer: "groups".to_owned(),
        offset: 4,
    };
    ShadowPlan {
        buffers: vec![written("groups", 4), written("found", 1)],
        passes: vec![
            Pass::Compute(compute("count", &["groups".into()], reads)),
            Pass::Compute(groups),
        ],
        asks: vec!["found".to_owned()],
        ..ShadowPlan::default()
    }
}

#[test]
fn the_device_counts_workgroups() {
    let mut lab = Lab::new(&[("count", COUNT), ("groups", GROUPS)], |_| counted(5));
    assert_eq!(lab.words(0, "found"), [10]);
    lab.plan_by(|_| counted(8));
    let done = lab.shadow(0, Answers::none()).expect("executed");
    assert_eq!(done.runs, [Run::Recorded; 2]);
    let answers = lab.answer(&done.question.expect("a question"));
    assert_eq!(words(&answers, "found"), [16]);
    lab.plan_by(|_| counted(0));
    assert_eq!(lab.words(0, "found"), [0]);
}

type Spoil = fn(&mut ShadowPlan);

fn screen(plan: &mut ShadowPlan, number: usize) -> &mut ScreenPass {
    match &mut plan.passes[number] {
        Pass::Screen(pass) => pass,
        _ => unreachable!("a full-screen pass"),
    }
}

fn computed(plan: &mut ShadowPlan, number: usize) -> &mut ComputePass {
    match &mut plan.passes[number] {
        Pass::Compute(pass) => pass,
        _ => unreachable!("a compute pass"),
    }
}

fn casters(plan: &mut ShadowPlan, number: usize) -> &mut CasterPass {
    match &mut plan.passes[number] {
        Pass::Casters(pass) => pass,
        _ => unreachable!("a pass of casters"),
    }
}

/// Each fault names light, method and what is wrong; the light's shadow is there again once all is well, and another light's
/// stands.
fn told(mut lab: Lab, sound: fn() -> ShadowPlan, spoilt: &[(Spoil, &str)]) {
    lab.plan_by(move |_| sound());
    let first = lab.words(1, "found");
    for (spoil, expected) in spoilt {
        let spoil = *spoil;
        lab.plan_by(move |_| {
            let mut plan = sound();
            spoil(&mut plan);
            plan
        });
        let said = lab.refusal(0);
        assert!(said.contains(expected), "{said}\nlacks: {expected}");
        assert!(
            said.contains("light `sun`") && said.contains("method `probe`"),
            "{said}"
        );
        lab.plan_by(move |_| sound());
        assert_eq!(lab.words(0, "found"), first, "{expected}");
        let other = lab.shadow(1, Answers::none()).expect("executed");
        assert!(other.runs.iter().all(|run| *run == Run::Kept), "{expected}");
    }
}

#[test]
fn parts_of_textures_that_do_not_fit_are_told() {
    let lab = Lab::new(&PYRAMID, |_| pyramid(1.0));
    told(
        lab,
        || pyramid(1.0),
        &[
            (
                |plan| screen(plan, 1).reads = reads("finer", Source::level("pyramid", 1)),
                "`halve` reads level 1 of layer 0 of `pyramid`, which it writes",
            ),
            (
                |plan| screen(plan, 1).reads.renamed.clear(),
                "binding `finer` of probe::halve",
            ),
            (
                |plan| screen(plan, 1).reads = reads("finer", "pyramid".into()),
                "`halve` reads level 1 of layer 0 of `pyramid`, which it writes",
            ),
            (
                |plan| drop(plan.passes.remove(1)),
                "`store` reads level 1 of layer 0 of `pyramid`, which has no contents and no pass before writes",
            ),
            (
                |plan| plan.passes.swap(2, 3),
                "`levels` reads level 2 of layer 0 of `pyramid`, which has no contents and no pass before writes",
            ),
            (
                |plan| screen(plan, 1).targets[0].level = 3,
                "layer 0 of `pyramid`, level 3, which has 1 layers and 3 levels",
            ),
            (
                |plan| screen(plan, 1).viewport = all(3),
                "outside the 2 by 2 texels of `pyramid`",
            ),
            (
                |plan| screen(plan, 1).targets.clear(),
                "a full-screen pass into no texture",
            ),
            (
                |plan| computed(plan, 2).writes = vec!["pyramid".into()],
                "`store` stores to `pyramid`, which is not among what it `writes`",
            ),
            (
                |plan| plan.textures[0].levels = 4,
                "the texture `pyramid` has 4 mip levels, but the device allows from 1 to 3",
            ),
            (
                |plan| plan.textures[0].levels = 0,
                "the texture `pyramid` has 0 mip levels",
            ),
            (
                |plan| plan.textures[0].width = 1 << 20,
                "the texture `pyramid` has 1048576 by 4 texels",
            ),
            (
                |plan| plan.buffers[0] = written("found", 1 << 40),
                "the buffer `found` has 4398046511104 bytes",
            ),
            (
                |plan| plan.buffers[0] = written("found", 0),
                "the buffer `found` has 0 bytes",
            ),
            (
                |plan| plan.buffers[0].contents = BufferContents::Written(7),
                "7 bytes of the buffer `found`, no multiple of 4",
            ),
            (
                |plan| plan.buffers.push(written("pyramid", 1)),
                "two textures or buffers `pyramid`",
            ),
        ],
    );
}

#[test]
fn layers_that_do_not_fit_are_told() {
    let lab = Lab::new(&[("paint", PAINT), ("layers", LAYERS)], |_| layers());
    told(
        lab,
        layers,
        &[
            (
                |plan| casters(plan, 0).colors[0].target.layer = 6,
                "layer 6 of `reds`, level 0, which has 6 layers and 1 levels",
            ),
            (
                |plan| plan.textures[0].shape = TextureShape::Array(1 << 20),
                "the texture `reds` has 1048576 layers",
            ),
            (
                |plan| drop(plan.passes.remove(3)),
                "`layers` reads level 0 of layer 3 of `depths`, which has no contents and no pass before writes",
            ),
            (
                |plan| computed(plan, 6).reads = reads("one", "reds".into()),
                "the texture `reds` of 6 layers where a shader reads one of shape D2, layer None",
            ),
            (
                |plan| {
                    let one = Source {
                        layer: Some(6),
                        ..Source::from("reds")
                    };
                    computed(plan, 6).reads = reads("one", one);
                },
                "which has 6 layers and 1 levels",
            ),
            (
                |plan| {
                    let many = (0..6).flat_map(|layer| {
                        ["reds", "rests"].map(|name| color(name, layer, ColorWrites::RED))
                    });
                    casters(plan, 0).colors = many.collect();
                },
                "12 colours of 48 bytes a texel, where the device allows",
            ),
            (
                |plan| casters(plan, 0).colors[1] = color("reds", 0, ColorWrites::RED),
                "`paint` draws twice into level 0 of layer 0 of `reds`",
            ),
            (|plan| plan.textures[1].width = 4, "both must be as large"),
            (
                |plan| {
                    let third = color("reds", 1, ColorWrites::RED);
                    casters(plan, 0).colors.push(third);
                },
                "pass=paint gives no colour at location 2, and 3 colours are drawn into",
            ),
            (
                |plan| plan.textures[0].empty = f32::NAN,
                "the texture `reds`, empty at NaN: a finite number, of depth from 0 to 1, is needed",
            ),
            (
                |plan| plan.textures[2].empty = 1.5,
                "the texture `depths`, empty at 1.5",
            ),
            (
                |plan| {
                    casters(plan, 1).constants = Constants::new()
                        .with("red", f32::NAN)
                        .with("rest", Vec2::ZERO);
                },
                "the value for the shader's `red` is not finite",
            ),
            (
                |plan| casters(plan, 1).constants = Constants::new().with("rest", Vec2::ZERO),
                "the shader reads `red`, but no value is given for it",
            ),
            (
                |plan| plan.filter_radius = f64::NAN,
                "a filter's radius of NaN texels",
            ),
            (
                |plan| plan.shadow_distance = Some(f64::NAN),
                "a shadow distance of NaN m",
            ),
        ],
    );
}

/// A part that panics is told like any other that cannot plan.
#[test]
fn who_panics_is_told() {
    let mut lab = Lab::new(&[("count", COUNT), ("groups", GROUPS)], |_| counted(5));
    assert_eq!(lab.words(1, "found"), [10]);
    lab.plan_by(|frame| {
        let none: [u32; 0] = [];
        counted(none[frame.casters.casters.len()])
    });
    let said = lab.refusal(0);
    assert_eq!(
        said,
        "light `sun`: method `probe` panicked while it planned: index out of bounds: the len is 0 but the index is 1; this \
         is a fault of its parts: mend them, or choose others"
    );
    lab.plan_by(|_| counted(5));
    assert_eq!(lab.words(0, "found"), [10]);
    let other = lab.shadow(1, Answers::none()).expect("executed");
    assert_eq!(other.runs, [Run::Kept; 2]);
}

#[test]
fn workgroups_that_cannot_be_counted_are_told() {
    fn at(plan: &mut ShadowPlan, to: &str, offset: u64) {
        computed(plan, 1).workgroups = Workgroups::Indirect {
            buffer: to.to_owned(),
            offset,
        };
    }
    let lab = Lab::new(&[("count", COUNT), ("groups", GROUPS)], |_| counted(5));
    told(
        lab,
        || counted(5),
        &[
            (
                |plan| at(plan, "gone", 0),
                "workgroups of `groups` by the buffer `gone`, which is no buffer that its passes write",
            ),
            (
                |plan| at(plan, "groups", 8),
                "by the buffer `groups`, of 16 bytes, which has no three words from byte 8 on",
            ),
            (
                |plan| at(plan, "groups", 2),
                "of 16 bytes, which has no three words from byte 2 on",
            ),
            (
                |plan| at(plan, "found", 0),
                "of 4 bytes, which has no three words from byte 0 on",
            ),
            (
                |plan| plan.passes.swap(0, 1),
                "`groups` reads `groups`, which has no contents and no pass before writes",
            ),
            (
                |plan| computed(plan, 1).workgroups = [0, 1, 1].into(),
                "[0, 1, 1] workgroups of `groups`",
            ),
        ],
    );
}

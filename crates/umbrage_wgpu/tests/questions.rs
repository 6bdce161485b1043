//! Plans that end in questions: what passes wrote comes back, by the engine's hand, and is planned with.

mod common;

use common::{Lab, words};
use umbrage_shadow::{
    Answers, BufferContents, BufferDesc, ComputePass, Constants, Contents, MAX_QUESTIONS, Pass,
    Reads, ShadowPlan, TextureDesc, Value,
};
use umbrage_wgpu::{Error, Run};

/// Adds each texel of `numbers`, times a factor, to one sum, and counts them: 16 threads.
const SUM: &str = r#"
struct Numbers { factor: u32 }
@group(0) @binding(0) var<uniform> own: Numbers;
@group(0) @binding(1) var numbers: texture_2d<f32>;
struct Sum { sum: atomic<u32>, count: atomic<u32> }
@group(0) @binding(2) var<storage, read_write> sum: Sum;

@compute @workgroup_size(4, 4)
fn cs(@builtin(global_invocation_id) id: vec3u) {
    atomicAdd(&sum.sum, own.factor * u32(textureLoad(numbers, id.xy, 0).x));
    atomicAdd(&sum.count, 1u);
}
"#;

/// Twice each of two words.
const TWICE: &str = r#"
@group(0) @binding(0) var<storage, read> before: array<u32>;
@group(0) @binding(1) var<storage, read_write> after: array<u32>;

@compute @workgroup_size(2)
fn cs(@builtin(global_invocation_id) id: vec3u) {
    after[id.x] = 2u * before[id.x];
}
"#;

/// The bits of the camera's depth at a pixel.
const LOOK: &str = r#"
@group(0) @binding(0) var camera_depth: texture_depth_2d;
@group(0) @binding(1) var<storage, read_write> looked: array<u32>;

@compute @workgroup_size(1)
fn cs() {
    looked[0] = bitcast<u32>(textureLoad(camera_depth, vec2u(3, 1), 0));
}
"#;

fn written(name: &str, bytes: u64) -> BufferDesc {
    BufferDesc {
        name: name.to_owned(),
        contents: BufferContents::Written(bytes),
    }
}

fn compute(shader: &str, writes: &str, renamed: &[(&str, &str)], constants: Constants) -> Pass {
    let renamed = renamed.iter();
    let renamed = renamed.map(|(from, to)| ((*from).to_owned(), (*to).into()));
    Pass::Compute(ComputePass {
        shader: shader.to_owned(),
        workgroups: [1; 3].into(),
        writes: vec![writes.into()],
        reads: Reads {
            renamed: renamed.collect(),
            constants,
        },
    })
}

/// The numbers 0 to 15.
fn numbers(plan: &mut ShadowPlan) {
    let texels = (0..16_u8).flat_map(|number| f32::from(number).to_le_bytes());
    let format = wgpu::TextureFormat::R32Float;
    plan.textures
        .push(TextureDesc::d2("numbers", format, [4, 4]));
    plan.contents.push(Contents {
        texture: "numbers".to_owned(),
        bytes: texels.collect(),
    });
}

fn sum(factor: u32) -> Pass {
    let constants = Constants::new().with("factor", Value::U32(factor));
    compute("sum", "sum", &[], constants)
}

/// Sums, and asks for the sum; then sums three times as much, and doubles what it has.
fn sums() -> ShadowPlan {
    let mut plan = ShadowPlan {
        buffers: vec![written("sum", 8)],
        passes: vec![sum(1)],
        asks: vec!["sum".to_owned()],
        ..ShadowPlan::default()
    };
    numbers(&mut plan);
    plan
}

/// Answers come back, stand from frame to frame, and are planned with.
#[test]
fn what_passes_wrote_comes_back() {
    let mut lab = Lab::new(&[("sum", SUM), ("twice", TWICE)], |frame| {
        let mut plan = sums();
        match frame.answers.questions() {
            0 => {}
            1 => {
                // Two passes into one buffer, the first of which finds zeros; a further one that reads it.
                let times = words(frame.answers, "sum")[1];
                plan.buffers = vec![written("sum", 8), written("after", 8)];
                plan.passes.push(sum(times));
                plan.passes.push(compute(
                    "twice",
                    "after",
                    &[("before", "sum")],
                    Constants::new(),
                ));
                plan.asks.push("after".to_owned());
            }
            _ => plan.asks.clear(),
        }
        plan
    });
    let total: u32 = (0..16).sum();
    let first = lab.shadow(0, Answers::none()).expect("executed");
    assert_eq!(first.runs, [Run::Recorded]);
    let first = lab.answer(&first.question.expect("a question"));
    assert_eq!(
        (first.questions(), words(&first, "sum")),
        (1, vec![total, 16])
    );
    // It stands, and may be read back again.
    let again = lab.shadow(0, Answers::none()).expect("executed");
    assert_eq!(again.runs, [Run::Kept]);
    assert_eq!(lab.answer(&again.question.expect("a question")), first);
    for runs in [[Run::Recorded; 3], [Run::Kept; 3]] {
        let second = lab.shadow(0, &first).expect("executed");
        assert_eq!(second.runs, runs);
        let second = lab.answer(&second.question.expect("a question"));
        assert_eq!(second.questions(), 2);
        assert_eq!(words(&second, "sum"), [17 * total, 32]);
        assert_eq!(words(&second, "after"), [2 * 17 * total, 64]);
    }
    // The first plan has other passes into the buffer than the second one.
    assert_eq!(lab.words(0, "sum"), [total, 16]);
    let answers = first.with([]);
    let last = lab.shadow(0, &answers).expect("executed");
    assert_eq!(last.runs, [Run::Kept]);
    assert!(last.question.is_none());
}

/// A later plan's outcome stands, whatever is asked before it in each frame, and with answers of a frame before.
#[test]
fn what_is_shaded_by_stands_while_questions_are_asked() {
    let mut lab = Lab::new(&[("sum", SUM), ("twice", TWICE)], |frame| {
        let mut plan = sums();
        if frame.answers.questions() > 0 {
            plan.asks.clear();
            plan.buffers.push(written("after", 8));
            plan.passes.push(compute(
                "twice",
                "after",
                &[("before", "sum")],
                Constants::new(),
            ));
        }
        plan
    });
    let mut answers = Answers::default();
    for frame in 0..3 {
        let asked = lab.shadow(7, Answers::none()).expect("executed");
        let shaded = lab.shadow(7, &answers).expect("executed");
        let (first, second) = match frame {
            // No answer yet.
            0 => (Run::Recorded, vec![Run::Kept]),
            1 => (Run::Kept, vec![Run::Kept, Run::Recorded]),
            _ => (Run::Kept, vec![Run::Kept, Run::Kept]),
        };
        assert_eq!((asked.runs, shaded.runs), (vec![first], second), "{frame}");
        assert_eq!(shaded.resources.written.contains_key("after"), frame > 0);
        answers = lab.answer(&asked.question.expect("a question"));
    }
}

fn look(asks: &[&str]) -> ShadowPlan {
    ShadowPlan {
        buffers: vec![written("looked", 4)],
        passes: vec![compute("look", "looked", &[], Constants::new())],
        asks: asks.iter().map(|name| (*name).to_owned()).collect(),
        ..ShadowPlan::default()
    }
}

fn depth(lab: &Lab, depth: f32) -> wgpu::TextureView {
    use wgpu::TextureUsages as Usage;
    let format = wgpu::TextureFormat::Depth32Float;
    let usage = Usage::RENDER_ATTACHMENT | Usage::TEXTURE_BINDING;
    let size = wgpu::Extent3d {
        width: 4,
        height: 4,
        depth_or_array_layers: 1,
    };
    let made =
        umbrage_wgpu::device::texture(&lab.device, "depth", size, 1, format, usage).expect("fits");
    let view = made.create_view(&Default::default());
    let mut encoder = lab.device.create_command_encoder(&Default::default());
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: &view,
            depth_ops: Some(wgpu::Operations {
                load: wgpu::LoadOp::Clear(depth),
                store: wgpu::StoreOp::Store,
            }),
            stencil_ops: None,
        }),
        ..Default::default()
    });
    lab.queue.submit([encoder.finish()]);
    view
}

/// A pass that reads the camera's depth is run where that has another revision, and nowhere else.
#[test]
fn the_camera_s_depth_is_read() {
    let mut lab = Lab::new(&[("look", LOOK)], |_| look(&["looked"]));
    assert_eq!(
        lab.refusal(0),
        "light `sun`, method `probe`: the pass `look` reads the camera's depth, which is not given; give it \
         (`Job::camera_depth`), or have the frame say that there is none (`Frame::camera_depth`)"
    );
    for (held, revision, runs) in [
        (0.25, 1, Run::Recorded),
        (0.25, 1, Run::Kept),
        (0.75, 2, Run::Recorded),
    ] {
        lab.depth = Some((depth(&lab, held), revision));
        let done = lab.shadow(0, Answers::none()).expect("executed");
        assert_eq!(done.runs, [runs]);
        let answers = lab.answer(&done.question.expect("a question"));
        assert_eq!(words(&answers, "looked"), [held.to_bits()]);
    }
    let large = depth(&lab, 0.5);
    lab.told = [4, 5];
    let there = lab.depth.replace((large, 2));
    assert_eq!(
        lab.refusal(0),
        "light `sun`: the camera's depth is 4 by 4 texels, and the frame tells of Some([4, 5]): have it tell that \
         (`Frame::camera_depth`)"
    );
    (lab.told, lab.depth) = ([4, 4], there);
    // Where it is missing, nothing that stands is lost.
    let there = lab.depth.take();
    assert!(matches!(
        lab.shadow(0, Answers::none()),
        Err(Error::NoDepth { .. })
    ));
    lab.depth = there;
    let done = lab.shadow(0, Answers::none()).expect("executed");
    assert_eq!(done.runs, [Run::Kept]);
}

/// A method that asks without end, or about what there is not, is told so; other lights go on.
#[test]
fn bad_questions_are_told() {
    let mut lab = Lab::new(&[("look", LOOK), ("sum", SUM)], |_| look(&["looked"]));
    lab.depth = Some((depth(&lab, 0.5), 0));
    let mut answers = Answers::default();
    for round in 0..=MAX_QUESTIONS {
        match lab.shadow(0, &answers) {
            Ok(done) => answers = lab.answer(&done.question.expect("a question")),
            Err(error) => {
                assert_eq!(round, MAX_QUESTIONS);
                assert_eq!(
                    error.to_string(),
                    "light `sun`: method `probe` plans what cannot be done: one more question, about `looked`, where 4 \
                     were answered: so many may follow each other; this is a fault of the method: mend it, or choose \
                     another"
                );
                break;
            }
        }
    }
    assert_eq!(answers.questions(), MAX_QUESTIONS);
    lab.plan_by(|_| look(&["elsewhere"]));
    let said = lab.refusal(0);
    let expected = "a question about `elsewhere`, which is no buffer that its passes write";
    assert!(said.contains(expected), "{said}");
    lab.plan_by(|_| {
        let mut plan = look(&["looked", "idle"]);
        plan.buffers.push(written("idle", 4));
        plan
    });
    let said = lab.refusal(0);
    let expected = "a question about `idle`, which is no buffer that its passes write";
    assert!(said.contains(expected), "{said}");
    lab.plan_by(|_| ShadowPlan {
        buffers: vec![written("sum", 4)],
        ..sums()
    });
    let said = lab.refusal(0);
    let expected = "the buffer `sum` of 4 bytes, where a shader needs 8 at the least";
    assert!(said.contains(expected), "{said}");
    lab.plan_by(|_| look(&["looked"]));
    assert_eq!(lab.words(1, "looked"), [0.5_f32.to_bits()]);
}

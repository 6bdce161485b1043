//! Pipelines that workers make ahead of need.

use std::{
    sync::Arc,
    time::{Duration, Instant},
};

use umbrage_compose::{Composer, Key, Library, Package, Target};
use umbrage_testkit::headless;
use umbrage_wgpu::{ColorState, DrawState, Executor, Readiness, Vertices, Wanted};

/// A triangle in one of many shades, one a permutation.
fn shades(count: u32) -> Library {
    let values: String = (0..count)
        .map(|n| format!("\"{n}\": (features: [\"SHADE_{n}\"]),"))
        .collect();
    let lines: String = (0..count)
        .map(|n| format!("    @if(SHADE_{n}) {{ return vec4f({n}.0); }}\n"))
        .collect();
    let axes = format!(
        "(axes: {{ \"shade\": (default: \"none\", values: {{ \"none\": (), {values} }}), \
         \"pass\": (values: {{ \"main\": (root: \"package::main\") }}) }})"
    );
    let main = format!(
        "@vertex fn vs_main(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {{\n    \
         return vec4f(f32(i & 1u), f32(i >> 1u), 0.0, 1.0);\n}}\n\
         @fragment fn fs_main() -> @location(0) vec4f {{\n{lines}    return vec4f();\n}}\n"
    );
    let files = [("axes.ron", axes), ("main.wesl", main)];
    let files = files.map(|(path, text)| (path.to_owned(), text));
    let package = Package::from_sources("shades", "shades", files).expect("a package");
    Library::new([package]).expect("a library")
}

struct Lab {
    device: wgpu::Device,
    executor: Executor,
    composer: Arc<Composer>,
}

fn lab(count: u32) -> Lab {
    let (device, queue) = headless::device().expect("a device");
    let composer = Arc::new(Composer::new(shades(count), Target::webgpu()));
    Lab {
        executor: Executor::new(&device, &queue, Arc::clone(&composer)),
        device,
        composer,
    }
}

impl Lab {
    fn key(&self, shade: u32) -> Key {
        let shade = shade.to_string();
        let choices = [("pass", "main"), ("shade", shade.as_str())];
        self.composer.library().key(choices).expect("a key")
    }

    fn wanted(&self, shade: u32, format: wgpu::TextureFormat) -> Wanted {
        Wanted {
            keys: vec![self.key(shade)],
            state: DrawState {
                colors: vec![ColorState::new(format, None)],
                ..DrawState::NOTHING
            },
            mirrored: false,
            vertices: Vertices::default(),
        }
    }
}

const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

#[test]
fn what_is_asked_for_is_ready_in_a_later_frame() {
    let mut lab = lab(8);
    let wanted: Vec<_> = (0..8).map(|shade| lab.wanted(shade, FORMAT)).collect();
    for wanted in &wanted {
        let ready = lab.executor.prepare(wanted, 1).expect("no fault");
        assert_eq!(ready, Readiness::Waiting);
    }
    lab.executor.settle();
    for wanted in &wanted {
        let ready = lab.executor.prepare(wanted, 1).expect("no fault");
        assert_eq!(ready, Readiness::Ready);
    }
    let made: Vec<_> = lab.executor.pipelines().map(Arc::as_ptr).collect();
    assert_eq!(made.len(), 8);
    // They are those that a frame uses.
    for wanted in &wanted {
        let composed = lab.composer.compose(&wanted.keys[0]).expect("composes");
        let pipeline = lab
            .executor
            .pipeline(&composed.permutation, wanted.state.clone(), &[]);
        assert!(made.contains(&Arc::as_ptr(&pipeline.expect("a pipeline"))));
    }
    assert_eq!(lab.executor.backlog().waiting, 0);
}

#[test]
fn a_fault_is_told_once() {
    let mut lab = lab(2);
    // No colour can be drawn into a texture of depths: the device's own word.
    let refused = lab.wanted(0, wgpu::TextureFormat::Depth32Float);
    // Colours that the shader does not give: our own.
    let mut lacking = lab.wanted(1, FORMAT);
    lacking.state.colors.push(ColorState::new(FORMAT, None));
    for wanted in [&refused, &lacking] {
        let ready = lab.executor.prepare(wanted, 1).expect("not known yet");
        assert_eq!(ready, Readiness::Waiting);
    }
    lab.executor.settle();
    for (wanted, shade) in [(&refused, "shade=0"), (&lacking, "shade=1")] {
        let told = lab.executor.prepare(wanted, 1).expect_err("the fault");
        assert!(told.to_string().contains(shade), "{told}");
        for _ in 0..3 {
            let ready = lab.executor.prepare(wanted, 1).expect("told already");
            assert_eq!(ready, Readiness::Failed);
        }
    }
}

#[test]
fn a_lost_device_holds_nothing_up() {
    let mut lab = lab(40);
    let start = Instant::now();
    for shade in 0..20 {
        let wanted = lab.wanted(shade, FORMAT);
        lab.executor.prepare(&wanted, 1).expect("no fault");
    }
    lab.device.destroy();
    for shade in 20..40 {
        let wanted = lab.wanted(shade, FORMAT);
        lab.executor.prepare(&wanted, 1).expect("not known yet");
    }
    lab.executor.settle();
    assert_eq!(lab.executor.backlog().waiting, 0);
    for shade in 0..40 {
        let wanted = lab.wanted(shade, FORMAT);
        // Made before the loss, or its fault is told; or asked for again.
        let _ = lab.executor.prepare(&wanted, 1);
    }
    drop(lab);
    assert!(start.elapsed() < Duration::from_secs(120));
}

#[test]
fn thousands_of_wishes_have_bounded_room_and_what_has_none_is_told() {
    let mut lab = lab(1);
    for number in 0..3_000 {
        let mut wanted = lab.wanted(0, FORMAT);
        // Buffers of many strides, none of which the shader reads.
        wanted.vertices = Vertices::new(&[wgpu::VertexBufferLayout {
            array_stride: 4 * u64::from(number),
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &[],
        }]);
        lab.executor.prepare(&wanted, number).expect("no fault");
    }
    let backlog = lab.executor.backlog();
    assert!(backlog.waiting <= 1_024 + 64, "{backlog:?}");
    assert!(backlog.dropped > 0, "{backlog:?}");
    // Nobody waits for what is left.
    drop(lab);
}

//! Counts the instructions that the composer takes, and that frames take on the CPU, from plans to recorded commands: on a
//! device that does nothing, so that no driver is counted. Unlike times, counts are the same on a busy machine.
//!
//! Without an argument, each path runs in a process of its own under valgrind, and the counts are printed as JSON:
//! `cargo xtask test` holds them against `crates/umbrage_bench/benches.ron`. With the name of a path, that one runs.
#![allow(clippy::print_stdout, reason = "the counts are for standard output")]

use std::{
    collections::BTreeMap,
    env,
    error::Error,
    hint::black_box,
    process::{Command, Stdio},
    sync::Arc,
    thread,
};

use umbrage::{
    compose::{Composer, Target},
    render::{Gpu, RenderOptions, Renderer, Scene, Shadow},
    shader_library, wgpu,
};
use umbrage_bench::field::{Order, field, look};

type Result<T> = std::result::Result<T, Box<dyn Error + Send + Sync>>;

/// Work to be counted, with all that comes before it done.
type Work = Box<dyn FnOnce() -> Result<()>>;

/// A path's name, and how it is made ready.
type Path = (&'static str, fn() -> Result<Work>);

const PATHS: [Path; 7] = [
    ("compose_cold", compose_cold),
    ("compose_new", compose_new),
    ("compose_known", compose_known),
    ("check_100", check_100),
    ("frame_still", || frame(400, Order::Sorted, false)),
    ("frame_moving", || frame(400, Order::Sorted, true)),
    ("frame_moving_1600", || frame(1_600, Order::Shuffled, true)),
];

fn main() -> Result<()> {
    let Some(name) = env::args().nth(1) else {
        return count_all();
    };
    let path = PATHS.iter().find(|(known, _)| *known == name);
    let (_, ready) = path.ok_or_else(|| format!("no path is called `{name}`"))?;
    counted(ready()?)
}

/// The function whose instructions are counted, and those of all that it calls: valgrind finds it by its name.
#[inline(never)]
fn counted(work: Work) -> Result<()> {
    black_box(work())
}

/// Prints the counts of all paths.
fn count_all() -> Result<()> {
    // As many at once as there are cores: counts do not depend on it.
    let cores = thread::available_parallelism().map_or(1, usize::from);
    let mut counts = BTreeMap::new();
    for some in PATHS.chunks(cores) {
        let found = thread::scope(|scope| {
            let count = |(name, _): &(&'static str, _)| {
                let name = *name;
                scope.spawn(move || Ok::<_, Box<dyn Error + Send + Sync>>((name, count(name)?)))
            };
            let running: Vec<_> = some.iter().map(count).collect();
            let join = |thread: thread::ScopedJoinHandle<'_, Result<_>>| {
                thread
                    .join()
                    .unwrap_or_else(|_| Err("a thread panicked".into()))
            };
            running.into_iter().map(join).collect::<Result<Vec<_>>>()
        })?;
        counts.extend(found);
    }
    println!("{}", serde_json::to_string(&counts)?);
    Ok(())
}

/// Instructions of the path `name`.
fn count(name: &str) -> Result<u64> {
    let mut valgrind = Command::new("valgrind");
    valgrind
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg("--toggle-collect=*instructions*counted*")
        .arg(env::current_exe()?)
        .arg(name);
    let ran = valgrind.stdin(Stdio::null()).output();
    let ran = ran.map_err(|error| format!("valgrind could not be started: {error}"))?;
    let said = String::from_utf8_lossy(&ran.stderr);
    let count = said
        .lines()
        .find_map(|line| line.split_once("Collected :")?.1.trim().parse().ok());
    match count.filter(|count| *count > 0 && ran.status.success()) {
        Some(count) => Ok(count),
        None => Err(format!("`{name}` was not counted ({}): {said}", ran.status).into()),
    }
}

/// A permutation of real size, and others that between them know its modules.
const WANTED: &[(&str, &str)] = &[
    ("pass", "illumination"),
    ("surface", "ggx"),
    ("light", "spot"),
    ("method", "basic"),
    ("pcf", "5"),
    ("cookie", "on"),
    ("alpha_test", "on"),
    ("base_color_texture", "on"),
];
const OTHERS: [(&str, &str); 3] = [("surface", "lambert"), ("pcf", "7"), ("alpha_test", "off")];

fn composer() -> Result<Composer> {
    Ok(Composer::new(shader_library()?, Target::webgpu()))
}

/// The first permutation of a process.
fn compose_cold() -> Result<Work> {
    Ok(Box::new(|| {
        let composer = composer()?;
        let wanted = composer.library().key(WANTED.iter().copied())?;
        composer.compose(&wanted)?;
        Ok(())
    }))
}

/// A new permutation of modules that are known.
fn compose_new() -> Result<Work> {
    let composer = composer()?;
    for (axis, value) in OTHERS {
        let other = |&(known, old)| (known, if known == axis { value } else { old });
        let key = composer.library().key(WANTED.iter().map(other))?;
        composer.compose(&key)?;
    }
    let wanted = composer.library().key(WANTED.iter().copied())?;
    Ok(Box::new(move || {
        composer.compose(&wanted)?;
        Ok(())
    }))
}

/// A thousand look-ups of a permutation that is known.
fn compose_known() -> Result<Work> {
    let composer = composer()?;
    let wanted = composer.library().key(WANTED.iter().copied())?;
    composer.compose(&wanted)?;
    Ok(Box::new(move || {
        for _ in 0..1_000 {
            black_box(composer.compose(black_box(&wanted))?);
        }
        Ok(())
    }))
}

/// A hundred permutations of the space, found and checked.
fn check_100() -> Result<Work> {
    let composer = composer()?;
    Ok(Box::new(move || {
        for variant in composer.variants().take(100) {
            if let Some(fault) = composer.check(&variant).fault {
                return Err(fault.to_string().into());
            }
        }
        Ok(())
    }))
}

/// A frame of a field of boxes with four shadow maps, after others that made what it needs.
fn frame(boxes: usize, order: Order, moving: bool) -> Result<Work> {
    let composer = Arc::new(composer()?);
    let mut renderer = Renderer::new(nothing()?, composer, umbrage::methods::registry()?);
    let mut scene = field(boxes, order);
    let options = RenderOptions {
        // Reading back is no part of it.
        width: 64,
        height: 64,
        shadow: Shadow::new("pssm").with("pcf", "3"),
        ..RenderOptions::default()
    };
    let mut draw = move |scene: &Scene| -> Result<()> {
        renderer.render(scene, &options)?;
        Ok(())
    };
    for frame in 0..3 {
        look(&mut scene, frame);
        draw(&scene)?;
    }
    if moving {
        look(&mut scene, 3);
    }
    Ok(Box::new(move || draw(&scene)))
}

/// A device that does nothing of what it is told.
fn nothing() -> Result<Arc<Gpu>> {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = wgpu::Backends::NOOP;
    descriptor.backend_options.noop = wgpu::NoopBackendOptions {
        enable: true,
        ..Default::default()
    };
    let instance = wgpu::Instance::new(descriptor);
    let adapter = instance.request_adapter(&wgpu::RequestAdapterOptions::default());
    let adapter = pollster::block_on(adapter)?;
    let device = adapter.request_device(&wgpu::DeviceDescriptor::default());
    let (device, queue) = pollster::block_on(device)?;
    Ok(Arc::new(Gpu::from_wgpu(device, queue, "nothing")))
}

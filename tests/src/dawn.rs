//! Dawn, the WebGPU of Chrome, which says of a shader whether WebGPU takes it: shader module and pipelines, on a
//! device without features and with the default limits.
//!
//! `cargo xtask test` installs it where Node is there, under `target/umbrage/dawn`. It needs no GPU.

use std::{
    io::{BufRead as _, BufReader, Write as _},
    path::{Path, PathBuf},
    process::{Child, ChildStdin, ChildStdout, Command, Stdio},
};

use naga::{
    AddressSpace, Binding, EntryPoint, Handle, Module, ScalarKind, ShaderStage, Type, TypeInner,
};
use serde_json::{Value, json};

/// Dawn in a process of its own, until it is dropped.
pub struct Dawn {
    child: Child,
    requests: Option<ChildStdin>,
    verdicts: BufReader<ChildStdout>,
}

impl Dawn {
    /// Dawn, where it is installed; none where it is not or `UMBRAGE_DAWN` is `off`, which is told on
    /// standard error. Panics if `UMBRAGE_DAWN` is `on` and Dawn does not start.
    pub fn start() -> Option<Self> {
        let wish = std::env::var("UMBRAGE_DAWN").unwrap_or_default();
        let home = Path::new(env!("CARGO_MANIFEST_DIR")).join("../target/umbrage/dawn");
        let started = match home.join("node_modules").is_dir() {
            _ if wish == "off" => Err("UMBRAGE_DAWN is `off`".to_owned()),
            true => Self::start_at(&home)
                .map_err(|error| format!("`node` could not be started: {error}")),
            false => Err("it is not installed; `cargo xtask test` does it".to_owned()),
        };
        match started {
            Ok(dawn) => Some(dawn),
            Err(reason) => {
                assert!(wish != "on", "Dawn gives no verdicts: {reason}");
                // Written directly: the test harness shows a macro's output only for tests that fail.
                let line = format!("Dawn's verdicts are passed over: {reason}\n");
                let _ = std::io::stderr().write_all(line.as_bytes());
                None
            }
        }
    }

    fn start_at(home: &Path) -> std::io::Result<Self> {
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("dawn/verdicts.mjs");
        let mut child = Command::new("node")
            .args([script, PathBuf::from(home)])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()?;
        let requests = child.stdin.take();
        let verdicts = child.stdout.take().map(BufReader::new);
        Ok(Self {
            verdicts: verdicts.ok_or(std::io::ErrorKind::BrokenPipe)?,
            requests,
            child,
        })
    }

    /// Why Dawn refuses the shader `code` or a pipeline of its entry points; none where it takes all.
    pub fn refusal(&mut self, code: &str) -> Option<String> {
        // A module that naga cannot parse has no pipelines that we could list.
        let module = naga::front::wgsl::parse_str(code).unwrap_or_default();
        let request = json!({
            "code": code,
            "buffers": buffers(&module),
            "pipelines": pipelines(&module),
        });
        let answer = self.ask(&request).expect("Dawn answers");
        answer["refused"].as_str().map(str::to_owned)
    }

    fn ask(&mut self, request: &Value) -> std::io::Result<Value> {
        let requests = self.requests.as_mut();
        writeln!(requests.ok_or(std::io::ErrorKind::BrokenPipe)?, "{request}")?;
        let mut line = String::new();
        while self.verdicts.read_line(&mut line)? > 0 {
            if let Some(verdict) = line.strip_prefix("verdict ") {
                return Ok(serde_json::from_str(verdict)?);
            }
            // A warning of Dawn's own.
            line.clear();
        }
        Err(std::io::ErrorKind::UnexpectedEof.into())
    }
}

impl Drop for Dawn {
    fn drop(&mut self) {
        // It ends with its input.
        self.requests = None;
        let _ = self.child.wait();
    }
}

/// The buffers that a module binds, each of the least size that will do.
fn buffers(module: &Module) -> Vec<Value> {
    let variables = module.global_variables.iter();
    variables
        .filter_map(|(_, variable)| {
            let kind = match variable.space {
                AddressSpace::Uniform => "uniform",
                AddressSpace::Storage { .. } => "storage",
                _ => return None,
            };
            let size = module.types[variable.ty].inner.size(module.to_ctx());
            Some(json!({ "type": kind, "size": size.max(4) }))
        })
        .collect()
}

/// The pipelines of a module's entry points, as `verdicts.mjs` takes them. Each fragment stage must fit a vertex
/// stage of its module; where there is none, it gets one that fits.
fn pipelines(module: &Module) -> Vec<Vec<Value>> {
    let of = |stage| {
        let entries = module.entry_points.iter();
        entries.filter(move |entry| entry.stage == stage)
    };
    let mut all = Vec::new();
    for entry in of(ShaderStage::Compute) {
        all.push(vec![json!({ "compute": entry.name })]);
    }
    for vertex in of(ShaderStage::Vertex) {
        all.push(vec![
            json!({ "vertex": vertex.name, "inputs": attributes(module, vertex) }),
        ]);
    }
    for fragment in of(ShaderStage::Fragment) {
        let outputs = targets(module, fragment);
        let mut alternatives: Vec<_> = of(ShaderStage::Vertex)
            .map(|vertex| {
                json!({
                    "vertex": vertex.name, "inputs": attributes(module, vertex),
                    "fragment": fragment.name, "outputs": outputs,
                })
            })
            .collect();
        if alternatives.is_empty() {
            alternatives.push(json!({
                "vertex": "vs_before", "inputs": [], "before": vertex_stage_for(module, fragment),
                "fragment": fragment.name, "outputs": outputs,
            }));
        }
        all.push(alternatives);
    }
    all
}

/// Inputs or outputs of an entry point, each with its binding.
fn bound(
    module: &Module,
    ty: Handle<Type>,
    binding: &Option<Binding>,
) -> Vec<(Handle<Type>, Option<Binding>)> {
    match &module.types[ty].inner {
        TypeInner::Struct { members, .. } => members
            .iter()
            .map(|member| (member.ty, member.binding.clone()))
            .collect(),
        _ => vec![(ty, binding.clone())],
    }
}

fn inputs(module: &Module, entry: &EntryPoint) -> Vec<(Handle<Type>, Option<Binding>)> {
    let arguments = entry.function.arguments.iter();
    arguments
        .flat_map(|argument| bound(module, argument.ty, &argument.binding))
        .collect()
}

fn scalar(module: &Module, ty: Handle<Type>) -> (u8, &'static str) {
    let (components, scalar) = match module.types[ty].inner {
        TypeInner::Scalar(scalar) => (1, scalar),
        TypeInner::Vector { size, scalar } => (size as u8, scalar),
        _ => (1, naga::Scalar::F32),
    };
    let name = match (scalar.kind, scalar.width) {
        (ScalarKind::Sint, _) => "i32",
        (ScalarKind::Uint, _) => "u32",
        (_, 2) => "f16",
        _ => "f32",
    };
    (components, name)
}

fn attributes(module: &Module, vertex: &EntryPoint) -> Vec<Value> {
    let mut attributes = Vec::new();
    for (ty, binding) in inputs(module, vertex) {
        let Some(Binding::Location { location, .. }) = binding else {
            continue;
        };
        let (components, scalar) = scalar(module, ty);
        let kind = match scalar {
            "i32" => "sint32",
            "u32" => "uint32",
            "f16" => "float16",
            _ => "float32",
        };
        let format = match components {
            1 => kind.to_owned(),
            _ => format!("{kind}x{components}"),
        };
        attributes.push(json!({ "location": location, "format": format }));
    }
    attributes
}

/// A format for each colour that `fragment` writes: the smallest of its kind.
fn targets(module: &Module, fragment: &EntryPoint) -> Vec<Option<&'static str>> {
    let mut targets = Vec::new();
    let result = fragment.function.result.iter();
    for (ty, binding) in result.flat_map(|result| bound(module, result.ty, &result.binding)) {
        let Some(Binding::Location { location, .. }) = binding else {
            continue;
        };
        // A location beyond the last allowed one is refused as any other.
        let index = location.min(8) as usize;
        if targets.len() <= index {
            targets.resize(index + 1, None);
        }
        targets[index] = Some(match scalar(module, ty).1 {
            "i32" => "r8sint",
            "u32" => "r8uint",
            _ => "r8unorm",
        });
    }
    targets
}

/// The WGSL of a vertex stage that gives what `fragment` takes.
fn vertex_stage_for(module: &Module, fragment: &EntryPoint) -> String {
    let mut members = "@builtin(position) position: vec4f,".to_owned();
    for (ty, binding) in inputs(module, fragment) {
        let Some(Binding::Location {
            location,
            interpolation,
            sampling,
            ..
        }) = binding
        else {
            continue;
        };
        let (components, scalar) = scalar(module, ty);
        let ty = match components {
            1 => scalar.to_owned(),
            _ => format!("vec{components}<{scalar}>"),
        };
        let lower = |word: String| word.to_lowercase();
        let interpolation = match (interpolation, sampling) {
            (Some(how), Some(at)) => format!(
                "@interpolate({}, {})",
                lower(format!("{how:?}")),
                lower(format!("{at:?}"))
            ),
            (Some(how), None) => format!("@interpolate({})", lower(format!("{how:?}"))),
            _ => String::new(),
        };
        members += &format!("\n@location({location}) {interpolation} v{location}: {ty},");
    }
    format!(
        "struct Before {{ {members} }}\n\
         @vertex fn vs_before() -> Before {{ var before: Before; return before; }}\n"
    )
}

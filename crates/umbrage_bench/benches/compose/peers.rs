//! Other composers at the same permutation: `naga_oil` and `wesl`, given the shader library's own modules.
//!
//! Binding interfaces and choosing binding numbers is our linker's work, of which both are spared: each import names the
//! module that has the function for this key, and each resource has a number of its own. The rest reaches `wesl` as it is
//! written, and naga_oil in its own dialect, line by line. Conditions are left for both to decide.

use std::{
    collections::{BTreeMap, BTreeSet, HashMap},
    error::Error,
    fs,
    path::Path,
};

use naga_oil::compose::{
    ComposableModuleDescriptor, Composer, NagaModuleDescriptor, ShaderDefValue,
};
use serde::Deserialize;
use umbrage_compose::{Key, Library, Target};
use wesl::{CompileOptions, ManglerKind, ModulePath, VirtualResolver, Wesl};

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// Features of a key, and the modules that it leads to under whatever features.
#[derive(Default)]
pub(crate) struct Sources {
    features: BTreeSet<String>,
    /// Paths and texts, each after those that it imports from; the root is the last.
    modules: Vec<(String, String)>,
    bound: HashMap<String, String>,
    resources: usize,
}

#[derive(Deserialize)]
struct AxesFile {
    axes: BTreeMap<String, AxisOfFile>,
}

#[derive(Deserialize)]
struct AxisOfFile {
    values: BTreeMap<String, Effect>,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct Effect {
    root: String,
    bind: BTreeMap<String, String>,
    features: Vec<String>,
}

impl Sources {
    pub(crate) fn of(library: &Library, key: &Key) -> Result<Self> {
        let mut sources = Self::default();
        let mut root = String::new();
        let file: AxesFile = ron::from_str(&fs::read_to_string(folder().join("axes.ron"))?)?;
        for (axis, choices) in file.axes {
            let value = library.axes().value(key, &axis).unwrap_or_default();
            let Some(effect) = choices.values.get(value) else {
                return Err(format!("the axis {axis} has no value {value:?}").into());
            };
            sources.features.extend(effect.features.iter().cloned());
            sources.bound.extend(effect.bind.clone());
            root.push_str(&effect.root);
        }
        sources.add(&root)?;
        Ok(sources)
    }

    /// Adds the module at `path` after all that it leads to.
    fn add(&mut self, path: &str) -> Result<()> {
        if self.modules.iter().any(|(known, _)| known == path) {
            return Ok(());
        }
        let mut text = String::new();
        for line in read(path)?.lines() {
            match line.split_once("import ") {
                Some((before, names)) if before.is_empty() || before.starts_with('@') => {
                    let names = self.bind(path, names.trim_end_matches(';'))?;
                    for (module, _) in &names {
                        self.add(module)?;
                    }
                    let names: Vec<_> = names
                        .iter()
                        .filter_map(|(module, name)| {
                            Some(format!("{}::{name}", module.strip_prefix("package::")?))
                        })
                        .collect();
                    text += &format!("{before}import package::{{{}}};\n", names.join(", "));
                }
                _ => text += &format!("{}\n", self.number(line)),
            }
        }
        self.modules.push((path.to_owned(), text));
        Ok(())
    }

    /// The names that an import lists, each with the module that has it: for an interface's functions the one bound.
    fn bind(&self, importer: &str, names: &str) -> Result<Vec<(String, String)>> {
        let parent = importer.rsplit_once("::").map_or("", |(parent, _)| parent);
        let names = match names.strip_prefix("super::") {
            Some(rest) => format!("{parent}::{rest}"),
            None => names.to_owned(),
        };
        let (module, names) = match names.split_once("::{") {
            Some((module, names)) => (module, names.trim_end_matches('}')),
            None => names.rsplit_once("::").ok_or("an import of no module")?,
        };
        let bound = self.bound.get(module).map_or(module, String::as_str);
        let text = read(module)?;
        let with_module = |name: &str| {
            let is_function = text.contains(&format!("fn {name}("));
            let module = if is_function { bound } else { module };
            (module.to_owned(), name.to_owned())
        };
        Ok(names.split(", ").map(with_module).collect())
    }

    /// A line in which a resource has a number that no other has.
    fn number(&mut self, line: &str) -> String {
        let Some((before, after)) = line.split_once("@binding(") else {
            return line.to_owned();
        };
        let (_, after) = after.split_once(')').unwrap_or_default();
        self.resources += 1;
        format!("{before}@binding({}){after}", self.resources)
    }

    fn root(&self) -> Result<&(String, String)> {
        Ok(self.modules.last().ok_or("there is no root")?)
    }
}

fn folder() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shader_lib")
}

fn read(module: &str) -> Result<String> {
    let path = module.trim_start_matches("package::").replace("::", "/");
    let path = folder().join(path).with_extension("wesl");
    Ok(fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?)
}

/// naga_oil with all modules added.
pub(crate) struct NagaOil {
    composer: Composer,
    root: String,
    features: HashMap<String, ShaderDefValue>,
}

impl NagaOil {
    pub(crate) fn new(sources: &Sources) -> Result<Self> {
        let mut composer = Composer::default().with_capabilities(Target::webgpu().capabilities());
        for (path, text) in &sources.modules {
            let text = format!("#define_import_path {path}\n{}", in_naga_oil(text)?);
            let module = ComposableModuleDescriptor {
                source: &text,
                file_path: path,
                ..ComposableModuleDescriptor::default()
            };
            let added = composer.add_composable_module(module).map(drop);
            added.map_err(|error| error.emit_to_string(&composer))?;
        }
        Ok(Self {
            composer,
            root: in_naga_oil(&sources.root()?.1)?,
            features: sources
                .features
                .iter()
                .map(|name| (name.clone(), ShaderDefValue::Bool(true)))
                .collect(),
        })
    }

    /// The permutation, validated. The modules, but for the root, are parsed once and then known.
    pub(crate) fn compose(&mut self) -> Result<naga::Module> {
        let wanted = NagaModuleDescriptor {
            source: &self.root,
            file_path: "root",
            shader_defs: self.features.clone(),
            ..NagaModuleDescriptor::default()
        };
        let made = self.composer.make_naga_module(wanted);
        made.map_err(|error| error.emit_to_string(&self.composer).into())
    }
}

/// A module in naga_oil's dialect: conditions and imports are lines that begin with `#`, and constants have types, as
/// it loses those without.
fn in_naga_oil(text: &str) -> Result<String> {
    let code: Vec<_> = text
        .lines()
        .map(|line| line.split("//").next().unwrap_or_default())
        .collect();
    let lines = conditions(&code.join("\n"))?;
    let lines = lines.lines().map(|line| {
        let line = line.trim_start();
        match line
            .strip_prefix("const ")
            .and_then(|rest| rest.split_once(" = "))
        {
            _ if line.starts_with("import ") => format!("#{line}\n"),
            Some((name, value)) if !name.contains(':') && !value.ends_with("u;") => {
                let ty = if value.contains('.') { "f32" } else { "i32" };
                format!("const {name}: {ty} = {value}\n")
            }
            _ => format!("{line}\n"),
        }
    });
    Ok(lines.collect())
}

/// `text` with each `@if`, `@elif` and `@else` a line before what it is about, and `#endif` after.
fn conditions(text: &str) -> Result<String> {
    let mut out = String::new();
    let mut rest = text;
    while let Some(at) = rest.find("@if(") {
        out += &rest[..at];
        rest = &rest[at..];
        let mut open = 0;
        loop {
            let condition = if open == 0 {
                rest.strip_prefix("@if(")
            } else {
                rest.trim_start().strip_prefix("@elif(")
            };
            if let Some((terms, after)) = condition.and_then(|text| text.split_once(')')) {
                let after_if = if open == 0 { "" } else { "else " };
                for term in terms.split(" && ") {
                    let (word, feature) = match term.strip_prefix('!') {
                        Some(feature) => ("ifndef", feature),
                        None => ("ifdef", term),
                    };
                    out += &format!("\n#{after_if}{word} {feature}");
                }
                open = open.max(terms.split(" && ").count());
                rest = after;
            } else if let Some(after) = rest.trim_start().strip_prefix("@else")
                && open == 1
            {
                out += "\n#else";
                rest = after;
            } else {
                break;
            }
            let (conditional, after) = rest.split_at(length(rest));
            out += &format!("\n{}\n", conditions(conditional)?);
            rest = after;
        }
        out += &"#endif\n".repeat(open);
    }
    if rest.contains("@else") || rest.contains("@elif") {
        return Err("naga_oil has no `else` to a condition of several features".into());
    }
    Ok(out + rest)
}

/// Bytes of the declaration, statement, member or parameter that `text` begins with.
fn length(text: &str) -> usize {
    let mut depth = 0;
    for (at, byte) in text.bytes().enumerate() {
        match byte {
            b'(' | b'[' | b'{' => depth += 1,
            b')' | b']' => depth -= 1,
            b'}' => {
                depth -= 1;
                if depth == 0 && !text[at + 1..].starts_with(';') {
                    return at + 1;
                }
            }
            b';' | b',' if depth == 0 => return at + 1,
            _ => {}
        }
    }
    text.len()
}

/// `wesl` with all modules in memory, which it parses each time.
pub(crate) struct WeslCompiler<'a> {
    compiler: Wesl<VirtualResolver<'a>>,
    root: ModulePath,
}

impl<'a> WeslCompiler<'a> {
    pub(crate) fn new(sources: &'a Sources) -> Result<Self> {
        let mut resolver = VirtualResolver::new();
        for (path, text) in &sources.modules {
            resolver.add_module(path.parse()?, text.into());
        }
        let mut compiler = Wesl::new_barebones().set_custom_resolver(resolver);
        compiler.set_options(CompileOptions::default());
        compiler.set_mangler(ManglerKind::Escape);
        compiler.set_features(sources.features.iter().map(|name| (name, true)));
        let root = sources.root()?.0.parse()?;
        Ok(Self { compiler, root })
    }

    /// The permutation as WGSL.
    pub(crate) fn compose(&self) -> Result<String> {
        Ok(self.compiler.compile(&self.root)?.to_string())
    }
}

/// Entry points of a module, and how many resources each group has: all that a host sees of it.
pub(crate) fn face(module: &naga::Module) -> (BTreeSet<&str>, BTreeMap<u32, usize>) {
    let entry_points = module.entry_points.iter().map(|point| point.name.as_str());
    let mut groups = BTreeMap::new();
    for (_, variable) in module.global_variables.iter() {
        if let Some(binding) = &variable.binding {
            *groups.entry(binding.group).or_default() += 1;
        }
    }
    (entry_points.collect(), groups)
}

//! Libraries: packages, their modules and axes.

use std::{
    collections::{BTreeMap, HashMap, HashSet},
    path::Path,
    sync::{Arc, OnceLock, PoisonError, RwLock},
};

use naga::{ArraySize, Handle, Span, Type, TypeInner, UniqueArena};
use rustc_hash::FxHashMap;
use umbrage_hints::{did_you_mean, nearest};

use crate::{
    Axes, Cause, Error, Fault, Key, Package, ValueId,
    axes::{CountFetches, Counting, EffectNumbers},
    bits::Bits,
    capabilities,
    features::FeatureNames,
    file::SourceText,
    names::may_stand_in_paths,
    package::Dependency,
    parts::{Question, Table},
    source::{Source, Syntax},
};

/// Packages, with their modules and axes. Cheap to clone.
#[derive(Clone, Debug)]
pub struct Library(Arc<Inner>);

#[derive(Debug)]
struct Inner {
    packages: Vec<PackageEntry>,
    sources: Vec<Source>,
    syntax: Vec<OnceLock<Result<Syntax, Fault>>>,
    by_path: HashMap<String, usize>,
    /// The modules that are interfaces.
    interfaces: Vec<usize>,
    is_interface: Vec<bool>,
    axes: Axes,
    features: FeatureNames,
    table: OnceLock<Table>,
    hashes: OnceLock<Hashes>,
    /// Files of the packages' axes.
    axes_files: Vec<SourceText>,
    /// Numbers of names, by which items are told apart faster than by text.
    names: RwLock<FxHashMap<String, u32>>,
    /// Types of all modules, each once.
    types: RwLock<UniqueArena<Type>>,
}

#[derive(Debug)]
struct PackageEntry {
    name: String,
    dependencies: BTreeMap<String, Dependency>,
    groups: BTreeMap<u32, u32>,
}

/// Hashes of what permutations follow from.
#[derive(Debug)]
struct Hashes {
    /// By module: its path, its text, and how its package's groups are numbered.
    modules: Vec<[u8; 32]>,
    /// By axis and value: its demands on the linker.
    demands: FxHashMap<(String, String), [u8; 32]>,
    whole: String,
}

/// Demands of a key on the linker, with modules as numbers.
#[derive(Clone, Debug, Default)]
pub(crate) struct Request {
    pub(crate) root: usize,
    /// The interface whose implementations the root calls in turn.
    pub(crate) each: Option<usize>,
    /// Interfaces and the modules that implement them.
    pub(crate) bindings: BTreeMap<usize, usize>,
    pub(crate) features: Bits,
    /// Functions to be called before each texture fetch.
    pub(crate) counting: Vec<Counting>,
}

impl Library {
    /// A library of `packages`, and of those that their `wesl.toml`s name by a path. Modules are
    /// read when a permutation first needs them.
    ///
    /// # Errors
    /// Two packages of one name, an unreadable dependency, and axes that contradict each other or
    /// name modules that do not exist.
    pub fn new(packages: impl IntoIterator<Item = Package>) -> Result<Self, Error> {
        let packages = with_dependencies(packages.into_iter().collect())?;
        let mut axes = Axes::default();
        let mut sources = Vec::new();
        let mut entries = Vec::new();
        let mut base = 0;
        for (index, package) in packages.iter().enumerate() {
            for (path, source) in &package.modules {
                sources.push(Source {
                    path: format!("{}::{path}", package.name),
                    package: index,
                    file: source.file.clone(),
                    text: source.text.clone(),
                    fault: source.fault.clone(),
                    base,
                });
                base += source.text.len() + 1;
            }
            entries.push(PackageEntry {
                name: package.name.clone(),
                dependencies: package.dependencies.clone(),
                groups: package.groups.clone(),
            });
        }
        let mut merged = Vec::new();
        for package in &packages {
            if let Some(source) = &package.axes {
                axes.merge(&package.name, source, &merged)?;
                merged.push(source);
            }
        }
        let by_path: HashMap<_, _> = sources
            .iter()
            .enumerate()
            .map(|(index, source)| (source.path.clone(), index))
            .collect();
        let features = FeatureNames::new(axes.features());
        let capabilities = FeatureNames::new(axes.capabilities());
        let module = |path: &String| by_path.get(path).copied();
        for effect in axes.effects_mut() {
            let bound = effect.bind.iter();
            effect.numbers = EffectNumbers {
                root: effect.root.as_ref().and_then(module),
                each: effect.each.as_ref().and_then(module),
                bind: bound
                    .filter_map(|(k, v)| Some((module(k)?, module(v)?)))
                    .collect(),
                features: features.set(&effect.features),
                provided: capabilities.set(&effect.provides),
                needed: capabilities.set(&effect.needs),
                counting: effect.count_fetches.as_ref().and_then(|count| {
                    let (path, function) = count.call.rsplit_once("::")?;
                    Some(Counting {
                        module: by_path.get(path).copied()?,
                        function: function.to_owned(),
                        except: count.except.iter().filter_map(module).collect(),
                        features: effect.features.clone(),
                    })
                }),
            };
        }
        let is_interface: Vec<_> = sources.iter().map(Source::is_interface).collect();
        let interfaces = (0..sources.len()).filter(|module| is_interface[*module]);
        let library = Self(Arc::new(Inner {
            packages: entries,
            syntax: sources.iter().map(|_| OnceLock::new()).collect(),
            sources,
            by_path,
            interfaces: interfaces.collect(),
            is_interface,
            axes,
            features,
            table: OnceLock::new(),
            hashes: OnceLock::new(),
            axes_files: packages.into_iter().filter_map(|p| p.axes).collect(),
            names: RwLock::default(),
            types: RwLock::default(),
        }));
        library.check_axes()?;
        Ok(library)
    }

    /// Warnings about the axes: values that set a feature which no module asks for.
    pub fn warnings(&self) -> Vec<Fault> {
        let is_word = |c: char| c.is_alphanumeric() || c == '_';
        let words = self
            .sources()
            .iter()
            .flat_map(|source| source.text.split(|c| !is_word(c)));
        let words: HashSet<&str> = words.collect();
        let mut warnings = Vec::new();
        for axis in self.axes().iter() {
            for (value, effect) in &axis.values {
                for feature in effect
                    .features
                    .iter()
                    .filter(|name| !words.contains(name.as_str()))
                {
                    let name = &axis.name;
                    let message = format!(
                        "{name}={value} sets the feature `{feature}`, which no module asks for"
                    );
                    let fault = Fault::new(Cause::Manifest, message);
                    let fault = fault.note(match did_you_mean(feature, words.iter().copied()) {
                        Some(hint) => format!("{hint} Else remove it"),
                        None => "remove it, or let a module ask for it".to_owned(),
                    });
                    warnings.push(self.in_axes(fault, &[name, "values", value, feature]));
                }
            }
        }
        warnings
    }

    /// The axes of all packages.
    pub fn axes(&self) -> &Axes {
        &self.0.axes
    }

    /// The key of `choices`: a value for each axis that is not to have its default.
    ///
    /// # Errors
    /// An unknown axis or value, an axis without a default and a value, and a combination in which
    /// a value lacks a capability that it needs.
    pub fn key<'a>(
        &self,
        choices: impl IntoIterator<Item = (&'a str, &'a str)>,
    ) -> Result<Key, Error> {
        Ok(self.axes().key(choices)?)
    }

    /// The key that `text` says, as a key is printed: `axis=value` for each axis that is not to have its default,
    /// between commas.
    ///
    /// # Errors
    /// Text of another shape, and what [`Self::key`] refuses.
    pub fn parse_key(&self, text: &str) -> Result<Key, Error> {
        let words = text
            .split(',')
            .map(str::trim)
            .filter(|word| !word.is_empty());
        let choices = words.map(|word| {
            let sides = word.split_once('=');
            sides
                .map(|(axis, value)| (axis.trim(), value.trim()))
                .ok_or_else(|| {
                    let message = format!("`{word}` in the key `{text}` is no choice");
                    Fault::new(Cause::Key, message)
                        .note("a key is AXIS=VALUE,AXIS=VALUE, such as light=spot,pass=shadow_term")
                })
        });
        self.key(choices.collect::<Result<Vec<_>, _>>()?)
    }

    /// The module in `file`, where the library has it.
    pub fn module_of_file(&self, file: &Path) -> Option<&str> {
        let whole = |path: &Path| path.canonicalize().ok();
        let wanted = whole(file)?;
        let mut sources = self.sources().iter();
        let source =
            sources.find(|source| whole(Path::new(&source.file)).as_ref() == Some(&wanted));
        source.map(|source| source.path.as_str())
    }

    /// Paths of all modules.
    pub fn modules(&self) -> impl Iterator<Item = &str> {
        self.sources().iter().map(|source| source.path.as_str())
    }

    /// The value `value` of `axis`, where there is one.
    pub fn value(&self, axis: &str, value: &str) -> Option<ValueId> {
        self.table().number(axis, value).map(ValueId)
    }

    /// Number of the legal keys, at most `u128::MAX`.
    pub fn legal_keys(&self) -> u128 {
        let table = self.table();
        table.count(&table.whole())
    }

    /// The axes as parts of the space need them.
    fn hashes(&self) -> &Hashes {
        self.0.hashes.get_or_init(|| {
            let mut whole = blake3::Hasher::new();
            let hash = |parts: &[&[u8]]| {
                let mut hasher = blake3::Hasher::new();
                for part in parts {
                    hasher.update(&(part.len() as u64).to_le_bytes());
                    hasher.update(part);
                }
                *hasher.finalize().as_bytes()
            };
            let modules = self.0.sources.iter().enumerate().map(|(module, source)| {
                let groups = format!("{:?}", self.groups(module));
                hash(&[
                    source.path.as_bytes(),
                    source.text.as_bytes(),
                    groups.as_bytes(),
                ])
            });
            let modules: Vec<_> = modules.collect();
            for module in &modules {
                whole.update(module);
            }
            for file in &self.0.axes_files {
                whole.update(&hash(&[file.text.as_bytes()]));
            }
            let mut demands = FxHashMap::default();
            for axis in self.axes().iter() {
                for (value, effect) in &axis.values {
                    let asked = (
                        &effect.root,
                        &effect.each,
                        &effect.bind,
                        &effect.features,
                        &effect.count_fetches,
                    );
                    let asked = hash(&[axis.name.as_bytes(), format!("{asked:?}").as_bytes()]);
                    demands.insert((axis.name.clone(), value.to_string()), asked);
                }
            }
            Hashes {
                modules,
                demands,
                whole: whole.finalize().to_hex().to_string(),
            }
        })
    }

    /// Whether both are of the same modules and axes.
    pub fn is_same(&self, other: &Self) -> bool {
        self.hash() == other.hash()
    }

    /// The hash of all modules and axes.
    pub(crate) fn hash(&self) -> String {
        self.hashes().whole.clone()
    }

    /// The hash of a module's text and of what its package says of it.
    pub(crate) fn module_hash(&self, module: usize) -> &[u8] {
        &self.hashes().modules[module]
    }

    /// Hashes of what each choice of `key` asks of the linker, in the order of the axes.
    pub(crate) fn demands(&self, key: &Key) -> impl Iterator<Item = &[u8]> {
        let demands = &self.hashes().demands;
        self.axes().iter().filter_map(|axis| {
            let value = self.axes().value(key, &axis.name)?;
            let demand = demands.get(&(axis.name.clone(), value.to_owned()))?;
            Some(demand.as_slice())
        })
    }

    pub(crate) fn table(&self) -> &Table {
        self.0.table.get_or_init(|| Table::new(self))
    }

    /// Number of a name: equal names have equal numbers.
    pub(crate) fn number(&self, name: &str) -> u32 {
        let names = self.0.names.read().unwrap_or_else(PoisonError::into_inner);
        if let Some(number) = names.get(name) {
            return *number;
        }
        drop(names);
        let mut names = self.0.names.write().unwrap_or_else(PoisonError::into_inner);
        let next = names.len() as u32;
        *names.entry(name.to_owned()).or_insert(next)
    }

    /// Numbers of a module's `types`, whose structs have the `names`: equal types have equal numbers. A type that
    /// depends on an override has none.
    pub(crate) fn type_numbers(
        &self,
        types: &UniqueArena<Type>,
        names: &[Option<String>],
    ) -> Vec<Option<usize>> {
        let mut known = self.0.types.write().unwrap_or_else(PoisonError::into_inner);
        let mut numbers: Vec<Option<Handle<Type>>> = Vec::with_capacity(types.len());
        for ((_, ty), name) in types.iter().zip(names) {
            let inner = renumbered(&ty.inner, &numbers);
            let ty = inner.map(|inner| Type {
                name: name.clone(),
                inner,
            });
            numbers.push(ty.map(|ty| known.insert(ty, Span::UNDEFINED)));
        }
        let numbers = numbers.into_iter();
        numbers.map(|ty| ty.map(|ty| ty.index())).collect()
    }

    pub(crate) fn features(&self) -> &FeatureNames {
        &self.0.features
    }

    /// The same library, in which other features are known.
    pub(crate) fn with_features(self, features: FeatureNames) -> Self {
        match Arc::try_unwrap(self.0) {
            Ok(inner) => Self(Arc::new(Inner { features, ..inner })),
            Err(shared) => Self(shared),
        }
    }

    pub(crate) fn sources(&self) -> &[Source] {
        &self.0.sources
    }

    /// The modules that are interfaces, by number.
    pub(crate) fn interfaces(&self) -> &[usize] {
        &self.0.interfaces
    }

    pub(crate) fn is_interface(&self, module: usize) -> bool {
        self.0.is_interface[module]
    }

    pub(crate) fn source(&self, module: usize) -> &Source {
        &self.0.sources[module]
    }

    pub(crate) fn syntax(&self, module: usize) -> Result<&Syntax, Fault> {
        let syntax = self.0.syntax[module].get_or_init(|| self.source(module).parse());
        syntax.as_ref().map_err(Fault::clone)
    }

    /// The module of the path `package::folder::module`.
    pub(crate) fn module(&self, path: &str) -> Option<usize> {
        self.0.by_path.get(path).copied()
    }

    /// The number of a bind group that `module` has as `group`.
    pub(crate) fn group(&self, module: usize, group: u32) -> u32 {
        self.groups(module).get(&group).copied().unwrap_or(group)
    }

    /// Bind groups by the numbers that `module` has for them, where these are others.
    pub(crate) fn groups(&self, module: usize) -> &BTreeMap<u32, u32> {
        &self.0.packages[self.source(module).package].groups
    }

    /// The name of the package that modules of `package` call `name`.
    pub(crate) fn package_name<'a>(&'a self, package: usize, name: &'a str) -> Option<&'a str> {
        let dependency = self.0.packages[package].dependencies.get(name);
        let name = dependency.map_or(name, |dependency| dependency.package.as_str());
        self.0
            .packages
            .iter()
            .any(|known| known.name == name)
            .then_some(name)
    }

    pub(crate) fn own_package_name(&self, package: usize) -> &str {
        &self.0.packages[package].name
    }

    pub(crate) fn package_names(&self) -> impl Iterator<Item = &str> {
        self.0.packages.iter().map(|package| package.name.as_str())
    }

    /// The module and offset of a place in linked modules' spans.
    pub(crate) fn locate(&self, offset: usize) -> Option<(usize, usize)> {
        let index = self
            .0
            .sources
            .partition_point(|source| source.base <= offset)
            .checked_sub(1)?;
        let within = offset - self.0.sources[index].base;
        (within <= self.0.sources[index].text.len()).then_some((index, within))
    }

    /// Demands of `key` on the linker.
    pub(crate) fn request(&self, key: &Key) -> Result<Request, Fault> {
        let mut root = None;
        let mut request = Request::default();
        for (_, effect) in self.axes().effects(key) {
            root = effect.numbers.root.or(root);
            request.each = effect.numbers.each.or(request.each);
            request.bindings.extend(effect.numbers.bind.iter().copied());
            request.features.union(&effect.numbers.features);
            request.counting.extend(effect.numbers.counting.clone());
        }
        request.root = root.ok_or_else(|| {
            Fault::new(
                Cause::Key,
                format!("the key {key} names no module to start from"),
            )
            .note("give some axis's value a `root` in axes.ron")
        })?;
        Ok(request)
    }

    /// Whether the modules that the axes name exist, and interfaces are interfaces.
    fn check_axes(&self) -> Result<(), Error> {
        for axis in self.axes().iter() {
            for (value, effect) in &axis.values {
                let modules = effect
                    .bind
                    .iter()
                    .flat_map(|(k, v)| [k, v])
                    .chain(&effect.root)
                    .chain(&effect.each)
                    .map(String::as_str)
                    .chain(effect.count_fetches.iter().flat_map(CountFetches::modules));
                for path in modules {
                    if self.module(path).is_none() {
                        let fault = self.no_module(Cause::Manifest, path);
                        return Err(self.in_axes(fault, &[&axis.name, "values", value]).into());
                    }
                }
                for interface in effect.bind.keys().chain(&effect.each) {
                    let module = self.module(interface);
                    if module.is_some_and(|module| !self.source(module).is_interface()) {
                        let message = format!("`{interface}` is no interface");
                        let fault = Fault::new(Cause::Manifest, message)
                            .note("interfaces lie in their package's folder `interface`");
                        return Err(self.in_axes(fault, &[&axis.name, "values", value]).into());
                    }
                }
            }
        }
        capabilities::check(self.axes()).map_err(|misuse| {
            let path: Vec<_> = misuse.path.iter().map(String::as_str).collect();
            self.in_axes(misuse.fault, &path)
        })?;
        match self.table().contradiction() {
            Some((question, values)) => Err(self.contradiction(question, values).into()),
            None => Ok(()),
        }
    }

    /// Fault of two values that answer `question` differently.
    fn contradiction(&self, question: Question, values: [usize; 2]) -> Fault {
        let [(axis, value), (other_axis, other)] = values.map(|value| self.table().name(value));
        let message = match question {
            Question::Binding(interface) => format!(
                "{axis}={value} and {other_axis}={other} bind `{}` to different modules, and may go together",
                self.source(interface).path
            ),
            _ => format!(
                "{axis}={value} and {other_axis}={other} each name a root module, and may go together"
            ),
        };
        let fault = Fault::new(Cause::Manifest, message).note(
            "let one of them need what only values without the other provide, or bind in one place only",
        );
        let fault = self.in_axes(fault, &[axis, "values", value]);
        self.in_axes(fault, &[other_axis, "values", other])
    }

    /// `fault` at the words of `path`, in the first file of axes that has them in this order.
    fn in_axes(&self, fault: Fault, path: &[&str]) -> Fault {
        let has = |text: &str| {
            let mut rest = text;
            path.iter().all(|word| match rest.find(word) {
                Some(at) => {
                    rest = &rest[at + word.len()..];
                    true
                }
                None => false,
            })
        };
        let mut files = self.0.axes_files.iter();
        match files.find(|source| has(&source.text)) {
            Some(source) => fault.at(crate::ron_text::literal(source, path)),
            None => fault,
        }
    }

    pub(crate) fn no_module(&self, cause: Cause, path: &str) -> Fault {
        let fault = Fault::new(cause, format!("no module `{path}`"));
        let known = self.sources().iter().map(|source| source.path.as_str());
        match nearest(path, known) {
            Some(near) if cause == Cause::Import && !near.split("::").all(may_stand_in_paths) => {
                fault.note(format!(
                    "`{near}` cannot be imported: no path can name it; rename its file"
                ))
            }
            Some(near) => fault.note(format!("did you mean `{near}`?")),
            None => {
                let packages: Vec<_> = self.package_names().collect();
                fault.note(format!("packages: {}", packages.join(", ")))
            }
        }
    }
}

/// `ty` with other handles for the types in it; none where one of them has none, or where it depends on an override.
fn renumbered(ty: &TypeInner, handles: &[Option<Handle<Type>>]) -> Option<TypeInner> {
    let other = |ty: &mut Handle<Type>| {
        *ty = handles.get(ty.index()).copied().flatten()?;
        Some(())
    };
    let mut ty = ty.clone();
    match &mut ty {
        TypeInner::Array {
            size: ArraySize::Pending(_),
            ..
        }
        | TypeInner::BindingArray {
            size: ArraySize::Pending(_),
            ..
        } => return None,
        TypeInner::Pointer { base, .. }
        | TypeInner::Array { base, .. }
        | TypeInner::BindingArray { base, .. } => other(base)?,
        TypeInner::Struct { members, .. } => {
            for member in members {
                other(&mut member.ty)?;
            }
        }
        _ => {}
    }
    Some(ty)
}

/// `packages`, and those that they name by a path, sorted by name.
fn with_dependencies(mut packages: Vec<Package>) -> Result<Vec<Package>, Error> {
    let mut next = 0;
    while next < packages.len() {
        for dependency in packages[next].dependencies.clone().into_values() {
            let known = packages
                .iter()
                .any(|package| package.name == dependency.package);
            if let (false, Some(path)) = (known, &dependency.path) {
                packages.push(Package::load(&dependency.package, path)?);
            }
        }
        next += 1;
    }
    packages.sort_by(|a, b| a.name.cmp(&b.name));
    match packages
        .windows(2)
        .find(|pair| pair[0].name == pair[1].name)
    {
        Some(pair) => {
            let message = format!("two packages are called `{}`", pair[0].name);
            Err(Fault::new(Cause::Manifest, message)
                .note("give one of them another name")
                .into())
        }
        None => Ok(packages),
    }
}

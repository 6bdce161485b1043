//! The composer: from a key to a permutation, by the shortest way.

use std::{
    borrow::Borrow,
    cell::RefCell,
    collections::{BTreeSet, HashMap},
    hash::Hash,
    path::PathBuf,
    sync::{Arc, OnceLock, PoisonError, RwLock},
};

use rustc_hash::FxHashSet;

use crate::{
    Cause, Error, Fault, Key, Library, Lint, Linted, Pack, Permutation, ProjectedKey, Target,
    bits::Bits,
    cache::{DiskCache, identity},
    checker::{ENTRY_POINT, Verdicts},
    diagnostics::Places,
    features::Features,
    fetches,
    library::Request,
    link::{Origins, Targets, Units, link},
    lints,
    names::ItemNumber,
    prepare::{Prepared, prepare},
    project::{Dependencies, Modules, dependencies, project},
    reach::{Reach, Roots, reach},
    several::{Part, Several},
    space::{Known, Read, Selection, Variant, Variants},
    store::Look,
    translate::TranslatedModules,
    unit::{Refusal, Unit, parse},
};

/// Composes permutations of a library for a target, and keeps what it has made.
///
/// A key is looked up in memory; then, projected on the choices that matter, in memory again; then
/// on disk; and only then linked, from modules that were each parsed once for the features that
/// they read.
#[derive(Debug)]
pub struct Composer {
    library: Library,
    target: Target,
    disk: Option<DiskCache>,
    pack: Option<Arc<Pack>>,
    /// By key, and by projected key.
    memory: Memory<Key, Arc<Permutation>>,
    /// The same of several keys, and faults: that lights are too many for one shader is asked in every frame.
    several: Memory<Vec<Key>, Result<Arc<Permutation>, Error>>,
    /// By module.
    modules: Vec<RwLock<Readings>>,
    translated: TranslatedModules,
    verdicts: Verdicts,
}

/// A module under features that agree on what it consults.
#[derive(Debug)]
pub(crate) struct Entry {
    pub(crate) prepared: Result<Arc<Prepared>, Fault>,
    /// Shared by entries of the same text and filters.
    unit: Arc<OnceLock<Result<Arc<Unit>, Refusal>>>,
}

/// Entries of a module, found by the answers to its questions for features, in the order in which it asks them.
#[derive(Debug)]
struct Readings {
    /// The first is the root.
    nodes: Vec<Reading>,
}

#[derive(Clone, Debug)]
enum Reading {
    Unknown,
    /// Asks for a feature: the nodes for when it is off and on.
    Asks(usize, [usize; 2]),
    Ends(Arc<Entry>),
}

impl Default for Readings {
    fn default() -> Self {
        let nodes = vec![Reading::Unknown];
        Self { nodes }
    }
}

impl Readings {
    /// Place at the end of the answers: an entry, nothing known yet, or the first feature that has no answer.
    fn find(&self, answer: impl Fn(usize) -> Option<bool>) -> (usize, &Reading) {
        let mut at = 0;
        while let Reading::Asks(feature, nodes) = &self.nodes[at] {
            match answer(*feature) {
                Some(on) => at = nodes[usize::from(on)],
                None => break,
            }
        }
        (at, &self.nodes[at])
    }

    /// Adds `entry`, found by asking for the features `asked`, of which `enabled` are on.
    fn add(&mut self, asked: &[usize], enabled: &Bits, entry: Arc<Entry>) {
        for &feature in asked {
            let (at, node) = self.find(|feature| Some(enabled.contains(feature)));
            if matches!(node, Reading::Unknown) {
                let next = self.nodes.len();
                self.nodes[at] = Reading::Asks(feature, [next, next + 1]);
                self.nodes.extend([Reading::Unknown, Reading::Unknown]);
            }
        }
        let (at, _) = self.find(|feature| Some(enabled.contains(feature)));
        self.nodes[at] = Reading::Ends(entry);
    }

    fn entries(&self) -> impl Iterator<Item = &Arc<Entry>> {
        self.nodes.iter().filter_map(|node| match node {
            Reading::Ends(entry) => Some(entry),
            _ => None,
        })
    }
}

impl Entry {
    /// Whether both are of one text, whose names mean the same.
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.unit, &other.unit)
    }
}

/// A permutation, and how it was come by.
#[derive(Clone, Debug)]
pub struct Composed {
    /// The permutation.
    pub permutation: Arc<Permutation>,
    /// Where it came from.
    pub source: Source,
    /// Warnings of what did no harm: damaged cache entries, a cache that cannot be
    /// written to, and the permutation's own, when it is composed or loaded.
    pub warnings: Vec<String>,
}

/// Outcome of checking a permutation.
#[derive(Clone, Debug)]
pub struct Checked {
    /// The first fault, where there is one.
    pub fault: Option<Error>,
    /// Warnings about the permutation.
    pub warnings: Vec<String>,
    /// Findings of lints in it. Parts that other permutations have too are looked at once, in one of these.
    pub lints: Vec<Linted>,
    /// Whether it was composed, because some part of it was new or has a fault or a warning.
    pub composed: bool,
}

/// Relation of a key's choice to a module, from the loosest to the closest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Nearness {
    /// The choice has nothing to do with the module.
    None,
    /// The choice names a module that imports this one, directly or not, or sets a feature that this one reads.
    Leads,
    /// The choice names the module.
    Names,
}

/// Where a permutation came from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// It was linked from its modules.
    Linked,
    /// This composer had it.
    Memory,
    /// The disk cache had it.
    Disk,
    /// The pack had it.
    Pack,
}

impl Composer {
    /// A composer for `library` and `target`.
    pub fn new(library: Library, target: Target) -> Self {
        let modules = library
            .sources()
            .iter()
            .map(|_| RwLock::default())
            .collect();
        Self {
            translated: TranslatedModules::new(&library),
            verdicts: Verdicts::new(&library),
            library,
            target,
            disk: None,
            pack: None,
            memory: RwLock::default(),
            several: RwLock::default(),
            modules,
        }
    }

    /// The same, with a disk cache in the folder `dir`, which is made if need be.
    ///
    /// # Errors
    /// A folder that cannot be made or written to.
    pub fn with_disk_cache(self, dir: impl Into<PathBuf>) -> Result<Self, Error> {
        Ok(Self {
            disk: Some(DiskCache::open(dir.into())?),
            ..self
        })
    }

    /// The same, with a pack of permutations that were made ahead: what it has is not composed. Of a permutation that it
    /// has not, [`Composed::warnings`] tell.
    pub fn with_pack(self, pack: Arc<Pack>) -> Self {
        Self {
            pack: Some(pack),
            ..self
        }
    }

    /// The pack.
    pub fn pack(&self) -> Option<&Arc<Pack>> {
        self.pack.as_ref()
    }

    /// The library.
    pub fn library(&self) -> &Library {
        &self.library
    }

    /// The target.
    pub fn target(&self) -> &Target {
        &self.target
    }

    /// The key that names `key`'s permutation, with every choice that makes no difference at its default as far as
    /// that is legal: keys with the same projection are one permutation.
    ///
    /// # Errors
    /// Faults in the modules that the key leads to, as far as that takes reading them.
    pub fn project(&self, key: &Key) -> Result<ProjectedKey, Error> {
        let (request, found) = self.read(key).map_err(|fault| fault.key(key))?;
        Ok(project(&self.library, &request, &found)
            .unwrap_or_else(|| ProjectedKey::of(key.clone())))
    }

    /// Relation of `key`'s choice on `axis` to the module that `fault` lies in.
    pub fn nearness(&self, key: &Key, axis: &str, fault: &Fault) -> Nearness {
        let library = &self.library;
        let effect = library
            .axes()
            .effects(key)
            .find(|(known, _)| known.name == axis);
        let file = fault.location().map(|at| &at.file);
        let sources = library.sources();
        let module = sources.iter().position(|source| Some(&source.file) == file);
        let (Some((_, effect)), Some(module), Ok(request)) = (effect, module, library.request(key))
        else {
            return Nearness::None;
        };
        let numbers = &effect.numbers;
        let named = (numbers.root.into_iter()).chain(numbers.bind.iter().map(|(_, to)| *to));
        let named: Vec<_> = named.collect();
        if named.contains(&module) {
            return Nearness::Names;
        }
        let with = WithFeatures {
            composer: self,
            enabled: &request.features,
        };
        let reads = |feature: &String| {
            let number = library.features().number(feature);
            let consulted = with
                .prepared(module)
                .map(|prepared| prepared.consulted.clone());
            // A module that could not be read may depend on any feature.
            number.is_some_and(|number| consulted.map_or(true, |read| read.asked.contains(number)))
        };
        if leads(&named, module, &with) || effect.features.iter().any(reads) {
            return Nearness::Leads;
        }
        Nearness::None
    }

    /// The permutation of `key`.
    ///
    /// # Errors
    /// Faults in the modules that the key leads to, and what the target does not allow.
    pub fn compose(&self, key: &Key) -> Result<Composed, Error> {
        if let Some(permutation) = self.remembered(key) {
            return Ok(Composed {
                permutation,
                source: Source::Memory,
                warnings: Vec::new(),
            });
        }
        let composed = self.compose_new(key).map_err(|fault| fault.key(key))?;
        self.remember(key, &composed.permutation);
        Ok(composed)
    }

    fn compose_new(&self, key: &Key) -> Result<Composed, Fault> {
        // A pack of the same sources knows a key's permutation without reading modules.
        if let Some(pack) = &self.pack {
            let request = self.library.request(key)?;
            // A damaged one is told of below.
            if let Ok(Some((key, identity))) = pack.find((&self.library, &self.target), &request) {
                if let Some(permutation) = self.remembered(&key) {
                    return Ok(Composed {
                        permutation,
                        source: Source::Memory,
                        warnings: Vec::new(),
                    });
                }
                let pass = self.library.axes().pass(&key);
                let keys = [key];
                let found = pack.by_identity(identity, (&keys, pass), &self.target);
                if let Ok(Some(permutation)) = found {
                    let composed = self.packed(permutation);
                    self.remember(&keys[0], &composed.permutation);
                    return Ok(composed);
                }
            }
        }
        let (request, found) = self.read(key)?;
        let projected = project(&self.library, &request, &found)
            .unwrap_or_else(|| ProjectedKey::of(key.clone()));
        if let Some(permutation) = self.remembered(&projected) {
            return Ok(Composed {
                permutation,
                source: Source::Memory,
                warnings: Vec::new(),
            });
        }
        let keys = [projected];
        let composed = self.on_disk_or(&keys, &[&found], || {
            self.make(&request, &found, keys[0].clone())
        })?;
        self.remember(&keys[0], &composed.permutation);
        Ok(composed)
    }

    fn packed(&self, permutation: Permutation) -> Composed {
        let warnings = permutation.warnings.clone();
        Composed {
            permutation: Arc::new(permutation),
            source: Source::Pack,
            warnings,
        }
    }

    /// The permutation of `keys`, which depends on what was `found` of each: from the pack or the disk, or as `make` makes
    /// it.
    fn on_disk_or(
        &self,
        keys: &[ProjectedKey],
        found: &[&Dependencies],
        make: impl FnOnce() -> Result<Permutation, Fault>,
    ) -> Result<Composed, Fault> {
        let mut warnings = Vec::new();
        if let Some(pack) = &self.pack {
            let name = DiskCache::name(&self.library, &self.target, keys, found);
            let pass = self.library.axes().pass(&keys[0]);
            match pack.by_identity(&name, (keys, pass), &self.target) {
                Ok(Some(permutation)) => return Ok(self.packed(permutation)),
                Ok(None) => {
                    let keys: Vec<_> = keys.iter().map(ToString::to_string).collect();
                    warnings.push(format!(
                        "the pack {} has no `{}` of these sources, naga and target, so it is composed",
                        pack.path().display(),
                        keys.join(" + ")
                    ));
                }
                Err(error) => warnings.push(error.to_string()),
            }
        }
        let on_disk = self.disk.as_ref().map(|disk| {
            let name = DiskCache::name(&self.library, &self.target, keys, found);
            (disk, name)
        });
        if let Some((disk, name)) = &on_disk {
            let pass = self.library.axes().pass(&keys[0]);
            match disk.look(name, (keys, pass), &self.target) {
                Look::Found(permutation) => {
                    warnings.extend(permutation.warnings.iter().cloned());
                    return Ok(Composed {
                        permutation: Arc::new(permutation),
                        source: Source::Disk,
                        warnings,
                    });
                }
                Look::Missing => {}
                Look::Dropped(warning) => warnings.push(warning),
            }
        }
        let permutation = make()?;
        if let Some((disk, name)) = &on_disk {
            warnings.extend(disk.keep(name, &permutation));
        }
        warnings.extend(permutation.warnings.iter().cloned());
        Ok(Composed {
            permutation: Arc::new(permutation),
            source: Source::Linked,
            warnings,
        })
    }

    /// One permutation of several keys, in the order given: where its pass's module calls a function of the interface that
    /// `axes.ron` names with `each`, it calls that of each key in turn. So a surface is shaded by several lights at
    /// once, each with a method and a filter of its own. What the pass reaches otherwise is there once, and has to be
    /// the same for all keys; each key's own resources are told apart by [`Binding::instance`](crate::Binding::instance). Uniform
    /// blocks of the second key and those after it are read-only storage buffers, as a stage has few uniform ones.
    ///
    /// # Errors
    /// No key, keys of another pass or of one that calls nothing in turn, keys that ask for what is there once in two
    /// ways, a function called in turn that gives something back, faults of each key's own permutation, and what the
    /// target does not allow, such as more textures than a stage may have.
    pub fn compose_all(&self, keys: &[Key]) -> Result<Composed, Error> {
        let first = match keys {
            [] => {
                let fault = Fault::new(Cause::Key, "no key, so no permutation");
                return Err(fault.note("give one key at the least").into());
            }
            [key] => return self.compose(key),
            [first, ..] => first,
        };
        let remembered = |known: Result<Arc<Permutation>, Error>| {
            Ok(Composed {
                permutation: known?,
                source: Source::Memory,
                warnings: Vec::new(),
            })
        };
        if let Some(known) = kept(&self.several, keys) {
            return remembered(known);
        }
        let projected = keys
            .iter()
            .map(|key| Ok(self.compose(key)?.permutation.key.clone()))
            .collect::<Result<Vec<_>, Error>>()?;
        let names: Vec<Key> = projected.iter().cloned().map(Key::from).collect();
        let composed = match kept(&self.several, &names) {
            Some(known) => remembered(known),
            None => self.compose_several(&projected).map_err(|fault| {
                let others: Vec<_> = keys[1..].iter().map(ToString::to_string).collect();
                let others = format!("in one shader with {}", others.join(" and "));
                fault.note(others).key(first).into()
            }),
        };
        let outcome = match &composed {
            Ok(composed) => Ok(composed.permutation.clone()),
            Err(error) => Err(error.clone()),
        };
        keep(&self.several, names, outcome.clone());
        keep(&self.several, keys.to_vec(), outcome);
        composed
    }

    /// The permutation of several keys, of which each makes one by itself.
    fn compose_several(&self, keys: &[ProjectedKey]) -> Result<Composed, Fault> {
        let parts = keys.iter().map(|key| {
            let (request, all) = self.read(key)?;
            let with = WithFeatures {
                composer: self,
                enabled: &request.features,
            };
            let (side, outcome) = dependencies(&request, request.each, &with);
            outcome.map(|()| Part {
                key: Key::clone(key),
                request,
                all,
                side,
            })
        });
        let parts = parts.collect::<Result<Vec<_>, Fault>>()?;
        let unit = |module: usize, entry: &Entry| self.unit(module, entry).cloned();
        let several = Several::new(&self.library, &parts, unit)?;
        let found: Vec<_> = parts.iter().map(|part| &part.all).collect();
        self.on_disk_or(keys, &found, || self.make_several(&parts, &several, keys))
    }

    fn make_several(
        &self,
        parts: &[Part],
        several: &Several,
        keys: &[ProjectedKey],
    ) -> Result<Permutation, Fault> {
        let units = parts.iter().map(|part| {
            let entries = part.all.entries.iter();
            let entries = entries.map(|(module, entry)| (*module, &**entry));
            AsRead::new(self, &part.request, entries)
        });
        let units = OfInstances {
            several,
            units: units.collect(),
        };
        let request = &several.requests[0];
        let targets = Targets::new(&self.library, request, &units).of_several(several);
        let reach = reach(&targets, request.root, Roots::EntryPoints)?;
        // No two instances share what an implementation by itself may not.
        let (module, origins) = link(&targets, &reach, Roots::EntryPoints, true)?;
        let (library, target) = (&self.library, &self.target);
        let linked = (module, &origins);
        let permutation = Permutation::new(library, target, keys[0].clone(), request.root, linked)?;
        Ok(Permutation {
            others: keys[1..].to_vec(),
            ..permutation
        })
    }

    /// Checks a permutation, as [`Self::compose`] would, but without making it where all its parts are known to be
    /// valid. It is not kept.
    pub fn check(&self, variant: &Variant<'_>) -> Checked {
        let checked = |fault, warnings, composed| Checked {
            fault,
            warnings,
            lints: Vec::new(),
            composed,
        };
        if let Some(fault) = variant.fault() {
            return checked(Some(fault), Vec::new(), false);
        }
        let request = variant.request();
        let units = AsRead::new(self, &request, variant.entries());
        let targets = Targets::new(&self.library, &request, &units);
        let proved = self.reach(&targets, variant.module_numbers());
        let proved = proved.and_then(|reach| match self.verdicts.known(&targets, &reach) {
            Some(_) => Ok(None),
            None => self.prove(&targets, &reach, variant.key()).map(Some),
        });
        match proved {
            Ok(None) => checked(None, Vec::new(), false),
            Ok(Some((permutation, origins))) => {
                let places = Places {
                    library: &self.library,
                    filters: &origins.filters,
                };
                let whole = (&self.target, request.root);
                Checked {
                    lints: lints::of_permutation(&permutation, &places, whole),
                    ..checked(None, permutation.warnings, true)
                }
            }
            Err(fault) => checked(Some(fault.key(&variant.key()).into()), Vec::new(), true),
        }
    }

    /// Links what `request` asks for, for which modules were `found`, and validates it where some part of it is not
    /// known to be valid.
    fn make(
        &self,
        request: &Request,
        found: &Dependencies,
        key: ProjectedKey,
    ) -> Result<Permutation, Fault> {
        let entries = found.entries.iter();
        let entries = entries.map(|(module, entry)| (*module, &**entry));
        let units = AsRead::new(self, request, entries);
        let targets = Targets::new(&self.library, request, &units);
        let reach = self.reach(&targets, &found.modules)?;
        self.make_reached(&targets, &reach, key)
    }

    fn make_reached(
        &self,
        targets: &Targets<'_>,
        reach: &Reach,
        key: ProjectedKey,
    ) -> Result<Permutation, Fault> {
        if let Some(uses) = self.verdicts.known(targets, reach) {
            let linked = link(targets, reach, Roots::EntryPoints, true)?;
            // The values of overrides come from validation.
            if linked.0.overrides.is_empty() {
                let (library, target) = (&self.library, &self.target);
                return Ok(Permutation::of_valid(library, target, key, linked, &uses));
            }
        }
        let (permutation, _) = self.prove(targets, reach, key)?;
        Ok(permutation)
    }

    /// Links and validates a permutation, and remembers that its parts are valid.
    fn prove(
        &self,
        targets: &Targets<'_>,
        reach: &Reach,
        key: ProjectedKey,
    ) -> Result<(Permutation, Origins), Fault> {
        let (library, request) = (&self.library, targets.request);
        let (module, origins) = link(targets, reach, Roots::EntryPoints, false)?;
        let linked = (module, &origins);
        let permutation = Permutation::new(library, &self.target, key, request.root, linked)?;
        for counting in &request.counting {
            fetches::check(library, request.root, counting, &permutation.module)?;
        }
        self.verdicts
            .learn(targets, reach, (&permutation, &origins));
        Ok((permutation, origins))
    }

    /// Findings of lints about the whole space, of which every permutation was [checked](Self::check) by this composer,
    /// without a fault or a warning: what none of them has use for.
    pub fn lint_space(&self) -> Vec<Linted> {
        lints::of_space(self)
    }

    /// Modules as naga parsed them so far.
    fn units(&self) -> Vec<(usize, Arc<Unit>)> {
        let mut units = Vec::new();
        for (module, readings) in self.modules.iter().enumerate() {
            let readings = readings.read().unwrap_or_else(PoisonError::into_inner);
            let parsed = readings
                .entries()
                .filter_map(|entry| match entry.unit.get() {
                    Some(Ok(unit)) => Some((module, unit.clone())),
                    _ => None,
                });
            units.extend(parsed);
        }
        units
    }

    /// Functions that some permutation calls, by the modules that the calls name.
    pub(crate) fn called(&self) -> FxHashSet<ItemNumber> {
        let parts = self.verdicts.parts();
        let mut called = FxHashSet::default();
        for (_, unit) in self.units() {
            let address = Arc::as_ptr(&unit) as u64;
            let functions = (0..).zip(&unit.facts);
            let entries = (ENTRY_POINT..).zip(&unit.entry_facts);
            for (place, facts) in functions.chain(entries) {
                if parts.contains(&(address, place)) {
                    let calls = facts.calls.iter();
                    called.extend(calls.map(|(callee, _)| unit.called[callee.index()]));
                }
            }
        }
        called
    }

    /// Variables that some permutation uses.
    pub(crate) fn used(&self) -> FxHashSet<ItemNumber> {
        self.verdicts.uses()
    }

    /// Bindings that the modules which permutations are made of declare, by module.
    pub(crate) fn declared_bindings(&self) -> BTreeSet<(usize, String)> {
        let mut declared = BTreeSet::new();
        for (module, unit) in self.units() {
            let variables = unit.module.global_variables.iter().zip(&unit.globals);
            let own = variables.filter(|((_, variable), item)| {
                item.module == module && variable.binding.is_some()
            });
            declared.extend(own.map(|(_, item)| (module, item.name.clone())));
        }
        declared
    }

    /// Whether a filter in some reading of `module` turns `lint` off at `offset`.
    pub(crate) fn is_off(&self, module: usize, lint: Lint, offset: usize) -> bool {
        let readings = &self.modules[module];
        let readings = readings.read().unwrap_or_else(PoisonError::into_inner);
        let mut prepared = readings
            .entries()
            .filter_map(|entry| entry.prepared.as_ref().ok());
        prepared.any(|prepared| lints::is_off(&prepared.filters, lint, offset))
    }

    /// The permutation of `variant`, which is not kept.
    pub(crate) fn make_alone(&self, variant: &Variant<'_>) -> Result<Permutation, Error> {
        let (request, key) = (variant.request(), variant.key());
        let units = AsRead::new(self, &request, variant.entries());
        let targets = Targets::new(&self.library, &request, &units);
        let made = self.reach(&targets, variant.module_numbers());
        let made = made.and_then(|reach| self.make_reached(&targets, &reach, key.clone()));
        Ok(made.map_err(|fault| fault.key(&key))?)
    }

    /// The hash of all that `variant`'s permutation follows from.
    pub(crate) fn identity(&self, variant: &Variant<'_>) -> String {
        let parts = [(&variant.key(), variant.module_numbers())];
        identity(&self.library, &self.target, parts)
    }

    fn reach(&self, targets: &Targets<'_>, modules: &Bits) -> Result<Reach, Fault> {
        // Naga checks a module's assertions when it parses it, which constants alone do not ask for.
        for module in modules.iter() {
            if self.library.syntax(module).is_ok_and(|own| own.asserts) {
                targets.units.unit(module)?;
            }
        }
        reach(targets, targets.request.root, Roots::EntryPoints)
    }

    /// The modules under `features`.
    pub(crate) fn modules<'a>(&'a self, features: &'a Bits) -> impl Modules + 'a {
        WithFeatures {
            composer: self,
            enabled: features,
        }
    }

    /// The unit of `module`, which was read.
    pub(crate) fn unit<'a>(&self, module: usize, read: &'a Entry) -> Result<&'a Arc<Unit>, Fault> {
        let prepared = read.prepared.as_ref().map_err(Fault::clone)?;
        let parsed = || parse(&self.library, module, prepared).map(Arc::new);
        let unit = read.unit.get_or_init(parsed).as_ref();
        unit.map_err(|refusal| refusal.fault.clone())
    }

    /// Links all that the module numbered `root` declares.
    pub(crate) fn link_declarations(&self, request: &Request) -> Result<Permutation, Fault> {
        let with = WithFeatures {
            composer: self,
            enabled: &request.features,
        };
        let targets = Targets::new(&self.library, request, &with);
        let reach = reach(&targets, request.root, Roots::Declarations)?;
        let (module, origins) = link(&targets, &reach, Roots::Declarations, false)?;
        let (key, linked) = (ProjectedKey::of(Key::default()), (module, &origins));
        Permutation::new(&self.library, &self.target, key, request.root, linked)
    }

    /// Reads the modules that `key` leads to.
    pub(crate) fn read(&self, key: &Key) -> Result<(Request, Dependencies), Fault> {
        let request = self.library.request(key)?;
        let (found, outcome) = self.dependencies(&request);
        outcome.map(|()| (request, found))
    }

    fn dependencies(&self, request: &Request) -> (Dependencies, Result<(), Fault>) {
        let with = WithFeatures {
            composer: self,
            enabled: &request.features,
        };
        dependencies(request, None, &with)
    }

    fn remembered(&self, key: &Key) -> Option<Arc<Permutation>> {
        kept(&self.memory, key)
    }

    /// Projected keys of all permutations that it composed, sorted: what a run of a program needs.
    pub fn composed(&self) -> Vec<ProjectedKey> {
        let memory = self.memory.read().unwrap_or_else(PoisonError::into_inner);
        let mut keys: Vec<_> = memory.values().map(|kept| kept.key.clone()).collect();
        keys.sort_unstable();
        keys.dedup();
        keys
    }

    fn remember(&self, key: &Key, permutation: &Arc<Permutation>) {
        keep(&self.memory, key.clone(), permutation.clone());
    }

    fn entry(&self, module: usize, enabled: &Bits) -> Arc<Entry> {
        let lock = &self.modules[module];
        let known = |readings: &Readings| {
            let (_, found) = readings.find(|feature| Some(enabled.contains(feature)));
            match found {
                Reading::Ends(entry) => Some(entry.clone()),
                _ => None,
            }
        };
        let found = known(&lock.read().unwrap_or_else(PoisonError::into_inner));
        if let Some(entry) = found {
            return entry;
        }
        let asked = RefCell::default();
        let features = Features {
            names: self.library.features(),
            enabled,
            asked: &asked,
        };
        let prepared = prepare(&self.library, module, &features, &self.translated).map(Arc::new);
        let mut readings = lock.write().unwrap_or_else(PoisonError::into_inner);
        // Another thread may have been faster.
        if let Some(entry) = known(&readings) {
            return entry;
        }
        let same = |entry: &&Arc<Entry>| match (&entry.prepared, &prepared) {
            // The same text has another meaning where its names are imported from other modules.
            (Ok(known), Ok(new)) => {
                known.text == new.text
                    && known.filters == new.filters
                    && known.stubs.items == new.stubs.items
            }
            _ => false,
        };
        let unit = readings.entries().find(same);
        let unit = unit.map_or_else(Arc::default, |entry| entry.unit.clone());
        let entry = Arc::new(Entry { prepared, unit });
        readings.add(&asked.into_inner(), enabled, entry.clone());
        entry
    }

    /// Each distinct permutation of the whole space, once, always in the same order. Keys are not listed: the work
    /// follows the number of permutations, and memory the depth of the questions that tell them apart.
    pub fn variants(&self) -> Variants<'_> {
        self.select(&Selection::all())
    }

    /// Each distinct permutation of the keys that `selection` has, once, in the order in which [`Self::variants`] has
    /// them.
    pub fn select(&self, selection: &Selection) -> Variants<'_> {
        Variants::new(self, selection)
    }

    /// `module` under features of which some are undecided.
    pub(crate) fn read_undecided(&self, module: usize, known: &Known) -> Read {
        let readings = self.modules[module]
            .read()
            .unwrap_or_else(PoisonError::into_inner);
        let (_, found) = readings.find(|feature| known.decided(feature));
        let found = found.clone();
        drop(readings);
        let entry = match found {
            Reading::Asks(feature, _) => return Read::Undecided(feature),
            Reading::Ends(entry) => entry,
            // Its next questions, up to the first undecided one, are the same however that one is answered.
            Reading::Unknown => {
                self.entry(module, &known.certain);
                return self.read_undecided(module, known);
            }
        };
        match &entry.prepared {
            Ok(_) => Read::Module(entry),
            Err(fault) => Read::Fault(fault.clone()),
        }
    }
}

type Memory<K, V> = RwLock<HashMap<K, V>>;

// A poisoned lock guards a map that is whole all the same: entries go in by one call.
fn kept<K: Eq + Hash + Borrow<Q>, Q: Eq + Hash + ?Sized, V: Clone>(
    memory: &Memory<K, V>,
    key: &Q,
) -> Option<V> {
    let memory = memory.read().unwrap_or_else(PoisonError::into_inner);
    memory.get(key).cloned()
}

fn keep<K: Eq + Hash, V>(memory: &Memory<K, V>, key: K, value: V) {
    let mut memory = memory.write().unwrap_or_else(PoisonError::into_inner);
    memory.entry(key).or_insert(value);
}

/// Whether one of the modules `from` imports `to`, directly or not.
fn leads(from: &[usize], to: usize, modules: &dyn Modules) -> bool {
    let mut waiting = from.to_vec();
    let mut seen = BTreeSet::new();
    while let Some(module) = waiting.pop() {
        if module == to {
            return true;
        }
        if seen.insert(module)
            && let Ok(prepared) = modules.prepared(module)
        {
            waiting.extend(&prepared.modules);
        }
    }
    false
}

/// The composer's modules under some features.
struct WithFeatures<'a> {
    composer: &'a Composer,
    enabled: &'a Bits,
}

impl Modules for WithFeatures<'_> {
    fn read(&self, module: usize) -> Arc<Entry> {
        self.composer.entry(module, self.enabled)
    }
}

impl Units for WithFeatures<'_> {
    fn unit(&self, module: usize) -> Result<Arc<Unit>, Fault> {
        let mut refusal = match self.parsed(module)? {
            Ok(unit) => return Ok(unit),
            Err(refusal) => refusal,
        };
        // A fault in what a module takes from another is told in the other, where its author sees it.
        let mut seen = vec![module];
        while let Some(blamed) = refusal.blamed.filter(|blamed| !seen.contains(blamed)) {
            seen.push(blamed);
            match self.parsed(blamed)? {
                Ok(_) => break,
                Err(own) => refusal = own,
            }
        }
        Err(refusal.fault)
    }
}

impl WithFeatures<'_> {
    fn parsed(&self, module: usize) -> Result<Result<Arc<Unit>, Refusal>, Fault> {
        let entry = self.composer.entry(module, self.enabled);
        let library = &self.composer.library;
        let prepared = entry.prepared.as_ref().map_err(Fault::clone)?;
        let parsed = || parse(library, module, prepared).map(Arc::new);
        Ok(entry.unit.get_or_init(parsed).clone())
    }
}

/// Modules as they were read.
struct AsRead<'a> {
    with: WithFeatures<'a>,
    /// By module.
    entries: Vec<Option<&'a Entry>>,
}

impl<'a> AsRead<'a> {
    fn new(
        composer: &'a Composer,
        request: &'a Request,
        read: impl Iterator<Item = (usize, &'a Entry)>,
    ) -> Self {
        let mut entries = vec![None; composer.modules.len()];
        for (module, entry) in read {
            entries[module] = Some(entry);
        }
        let with = WithFeatures {
            composer,
            enabled: &request.features,
        };
        Self { with, entries }
    }
}

impl Units for AsRead<'_> {
    fn unit(&self, module: usize) -> Result<Arc<Unit>, Fault> {
        let unit = self.entries[module].map(|entry| self.with.composer.unit(module, entry));
        match unit {
            Some(Ok(unit)) => Ok(unit.clone()),
            // A fault may lie in another module.
            _ => self.with.unit(module),
        }
    }
}

/// Modules of a shader of several keys, as each key has them.
struct OfInstances<'a> {
    several: &'a Several,
    units: Vec<AsRead<'a>>,
}

impl Units for OfInstances<'_> {
    fn unit(&self, number: usize) -> Result<Arc<Unit>, Fault> {
        let (instance, module) = (self.several.instance(number), self.several.module(number));
        self.units[instance].unit(module)
    }
}

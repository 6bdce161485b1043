//! Meanings of names: a module's own declarations, its imports, and paths written in code.

use std::{collections::BTreeMap, ops::Range};

use umbrage_hints::did_you_mean;
use wgsl_parse::syntax::{
    GlobalDeclaration, Import, ImportContent, ImportItem, ImportStatement, ModulePath, PathOrigin,
};

use crate::{Cause, Fault, Library, error::Place, source::Source, translate::Translated};

/// A declaration of a module.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct Item {
    pub(crate) module: usize,
    pub(crate) name: String,
}

/// An item by numbers: its module's, and [the library's](Library::number) of its name.
pub(crate) type ItemNumber = (u32, u32);

impl Item {
    pub(crate) fn number(&self, library: &Library) -> ItemNumber {
        (self.module as u32, library.number(&self.name))
    }
}

/// Meaning of an imported name.
#[derive(Clone, Debug)]
pub(crate) enum Meaning {
    Item(Item),
    /// A module, for paths that start with its name.
    Module(usize),
    /// Nothing: the name resolves to no item. That is a fault only where the name is used.
    Nothing(Fault),
}

impl Meaning {
    fn is(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Item(a), Self::Item(b)) => a == b,
            (Self::Module(a), Self::Module(b)) => a == b,
            _ => false,
        }
    }
}

/// `name` as paths write it, with `_` for `-`; a fault where no path can begin with it.
pub(crate) fn package_name(name: &str) -> Result<String, Fault> {
    let written = name.replace('-', "_");
    if may_stand_in_paths(&written) {
        return Ok(written);
    }
    let message = format!("`{name}` cannot be the name of a package");
    Err(Fault::new(Cause::Manifest, message).note(
        "paths begin with it: choose letters, digits and `_` (`-` counts as `_`), no digit first, no `__` \
         first, and none of `package`, `super`, `self`, `import`, `as` and `else`",
    ))
}

/// Whether the parser accepts `name` as part of a path.
pub(crate) fn may_stand_in_paths(name: &str) -> bool {
    let Ok(unit) = wgsl_parse::parse_str(&format!("import {name}::item;")) else {
        return false;
    };
    let is_name = |path: &ModulePath| {
        path.components.is_empty()
            && matches!(&path.origin, PathOrigin::Package(package) if package == name)
    };
    // Names become parts of WGSL identifiers, which must not begin with two underscores.
    !name.starts_with("__")
        && unit.global_declarations.is_empty()
        && (unit.imports.iter()).all(|import| import.path.as_ref().is_some_and(is_name))
}

/// The name that a declaration gives, if any.
pub(crate) fn declared(declaration: &GlobalDeclaration) -> Option<String> {
    let ident = match declaration {
        GlobalDeclaration::Declaration(item) => &item.ident,
        GlobalDeclaration::TypeAlias(item) => &item.ident,
        GlobalDeclaration::Struct(item) => &item.ident,
        GlobalDeclaration::Function(item) => &item.ident,
        GlobalDeclaration::Void | GlobalDeclaration::ConstAssert(_) => return None,
    };
    Some(ident.name().clone())
}

/// Gives the translation of another module, under the features in hand.
pub(crate) trait Translations {
    fn translated(&mut self, module: usize) -> Result<std::sync::Arc<Translated>, Fault>;
}

/// Names that `module`'s imports bring into scope. A name that resolves to nothing is a fault only where it is
/// used.
pub(crate) fn imports(
    library: &Library,
    module: usize,
    translated: &Translated,
    translations: &mut dyn Translations,
) -> Result<BTreeMap<String, Meaning>, Fault> {
    let source = library.source(module);
    let mut scope: BTreeMap<String, (Meaning, String)> = BTreeMap::new();
    for (statement, range) in &translated.imports {
        let site = Site {
            library,
            source,
            range: range.clone(),
        };
        for (written, path, item) in flatten(&site, statement) {
            let local = item.rename.as_ref().unwrap_or(&item.ident).name().clone();
            let meaning = path.and_then(|path| resolve(&site, &path, translations));
            let meaning = meaning.unwrap_or_else(Meaning::Nothing);
            if let Some((other, path)) = scope.get(&local)
                && !other.is(&meaning)
                && *path != written
            {
                let message = format!("`{local}` is imported from both `{path}` and `{written}`");
                return Err(Fault::new(Cause::Import, message)
                    .at(site.find(&local))
                    .note("rename one of them with `as`"));
            }
            let own = translated
                .declarations
                .iter()
                .find(|d| declared(d).as_ref() == Some(&local));
            if let Some(own) = own {
                let message = format!("`{local}` is imported from `{written}` and declared here");
                return Err(Fault::new(Cause::Import, message)
                    .at(source.place(own.span().range()))
                    .note("rename the import with `as`, or the declaration"));
            }
            scope.insert(local, (meaning, written));
        }
    }
    Ok(scope
        .into_iter()
        .map(|(local, (meaning, _))| (local, meaning))
        .collect())
}

/// A module, and the place in it at which a path is written.
struct Site<'a> {
    library: &'a Library,
    source: &'a Source,
    range: Range<usize>,
}

impl Site<'_> {
    fn find(&self, word: &str) -> Place<'_> {
        self.source.find_within(self.range.clone(), word)
    }
}

/// An item of an import: its path as written, its absolute path or the fault in it, and the item.
type Imported<'a> = (String, Result<Vec<String>, Fault>, &'a ImportItem);

/// Each item that `statement` imports: its path as written, its absolute path (beginning with its package) or the
/// fault in it, and the item.
fn flatten<'a>(site: &Site<'_>, statement: &'a ImportStatement) -> Vec<Imported<'a>> {
    let mut items = Vec::new();
    collect(&[], &statement.content, &mut items);
    let resolved = |(segments, item): (Vec<String>, &'a ImportItem)| {
        let (written, path) = match &statement.path {
            Some(path) => {
                let written = format!("{path}::{}", segments.join("::"));
                let absolute = absolute(site, path).map(|mut absolute| {
                    absolute.extend(segments);
                    absolute
                });
                (written, absolute)
            }
            // In a list with no path before it, each first name is a package.
            None => {
                let package = package(site, &segments[0]).map(str::to_owned);
                let written = segments.join("::");
                let path = package.map(|package| {
                    let rest = segments.into_iter().skip(1);
                    std::iter::once(package).chain(rest).collect()
                });
                (written, path)
            }
        };
        (written, path, item)
    };
    items.into_iter().map(resolved).collect()
}

fn collect<'a>(
    prefix: &[String],
    content: &'a ImportContent,
    items: &mut Vec<(Vec<String>, &'a ImportItem)>,
) {
    match content {
        ImportContent::Item(item) => {
            let mut segments = prefix.to_vec();
            segments.push(item.ident.name().clone());
            items.push((segments, item));
        }
        ImportContent::Collection(list) => {
            for Import { path, content } in list {
                let mut segments = prefix.to_vec();
                segments.extend(path.iter().cloned());
                collect(&segments, content, items);
            }
        }
    }
}

/// `path` from its package on.
fn absolute(site: &Site<'_>, path: &ModulePath) -> Result<Vec<String>, Fault> {
    let mut segments = match &path.origin {
        PathOrigin::Absolute => {
            vec![(site.library.own_package_name(site.source.package)).to_owned()]
        }
        PathOrigin::Relative(up) => parent(site, *up)?,
        PathOrigin::Package(name) => vec![package(site, name)?.to_owned()],
    };
    segments.extend(path.components.iter().cloned());
    Ok(segments)
}

/// Actual name of the package that the module calls `name`.
fn package<'a>(site: &Site<'a>, name: &'a str) -> Result<&'a str, Fault> {
    let known = site.library.package_name(site.source.package, name);
    known.ok_or_else(|| {
        let packages: Vec<_> = site.library.package_names().collect();
        let fault = Fault::new(Cause::Import, format!("no package `{name}`")).at(site.find(name));
        match did_you_mean(name, packages.iter().copied()) {
            Some(hint) => fault.note(hint),
            None => fault.note(format!("packages: {}", packages.join(", "))),
        }
    })
}

/// Path of the module without its last `up` parts.
fn parent(site: &Site<'_>, up: usize) -> Result<Vec<String>, Fault> {
    let path = &site.source.path;
    let mut segments: Vec<_> = path.split("::").map(str::to_owned).collect();
    if up >= segments.len() {
        let message = format!("`super` leaves the package: `{path}` is not so deep");
        return Err(Fault::new(Cause::Import, message).at(site.find("super")));
    }
    segments.truncate(segments.len() - up);
    Ok(segments)
}

/// Meaning of a path written in code, at `range`: its first name may be an imported module.
pub(crate) fn written_path(
    library: &Library,
    (source, range): (&Source, Range<usize>),
    scope: &BTreeMap<String, Meaning>,
    segments: &[&str],
    translations: &mut dyn Translations,
) -> Result<Item, Fault> {
    let site = Site {
        library,
        source,
        range,
    };
    let [first, rest @ ..] = segments else {
        return Err(Fault::new(Cause::Import, "an empty path"));
    };
    let supers = segments
        .iter()
        .take_while(|segment| **segment == "super")
        .count();
    let mut path = match (*first, scope.get(*first)) {
        ("package", _) => vec![library.own_package_name(source.package).to_owned()],
        ("super", _) => parent(&site, supers)?,
        ("self", _) => parent(&site, 0)?,
        (_, Some(Meaning::Nothing(fault))) => return Err(fault.clone()),
        (_, Some(Meaning::Module(module))) => library
            .source(*module)
            .path
            .split("::")
            .map(str::to_owned)
            .collect(),
        (name, _) => match package(&site, name) {
            Ok(name) => vec![name.to_owned()],
            Err(fault) => {
                return Err(fault.note(
                    "a path starts with `package`, `super`, a package, or a module that is imported",
                ));
            }
        },
    };
    let rest = if supers > 1 {
        &rest[supers - 1..]
    } else {
        rest
    };
    path.extend(rest.iter().map(|segment| (*segment).to_owned()));
    match resolve(&site, &path, translations)? {
        Meaning::Item(item) => Ok(item),
        Meaning::Nothing(fault) => Err(fault),
        Meaning::Module(_) => {
            let message = format!("`{}` is a module, not a declaration", segments.join("::"));
            Err(Fault::new(Cause::Import, message).note("name something in it"))
        }
    }
}

/// Meaning of the absolute path `segments`: a declaration of a module, or a module.
fn resolve(
    site: &Site<'_>,
    segments: &[String],
    translations: &mut dyn Translations,
) -> Result<Meaning, Fault> {
    let library = site.library;
    let (name, parents) = segments
        .split_last()
        .map_or(("", &[][..]), |(n, p)| (n.as_str(), p));
    let parent = parents.join("::");
    if let Some(module) = library.module(&parent) {
        let translated = translations.translated(module)?;
        let names: Vec<_> = translated
            .declarations
            .iter()
            .filter_map(|d| declared(d))
            .collect();
        if names.iter().any(|known| known == name) {
            return Ok(Meaning::Item(Item {
                module,
                name: name.to_owned(),
            }));
        }
        if library.module(&segments.join("::")).is_none() {
            let fault = Fault::new(Cause::Import, format!("module `{parent}` has no `{name}`"))
                .at(site.find(name));
            let elsewhere = library.syntax(module)?.tree.global_declarations.iter();
            if let Some(hidden) = elsewhere
                .into_iter()
                .find(|d| declared(d).as_deref() == Some(name))
            {
                let place = library.source(module);
                return Err(fault.at(
                    place.place_labelled(hidden.span().range(), "there only under other features")
                ));
            }
            return Err(match did_you_mean(name, names.iter().map(String::as_str)) {
                Some(hint) => fault.note(hint),
                None => fault.note(format!("it has {}", names.join(", "))),
            });
        }
    }
    let path = segments.join("::");
    match library.module(&path) {
        Some(module) => Ok(Meaning::Module(module)),
        None => {
            let named = if parents.len() > 1 { &parent } else { &path };
            let last = named.rsplit("::").next().unwrap_or(named);
            Err(library.no_module(Cause::Import, named).at(site.find(last)))
        }
    }
}

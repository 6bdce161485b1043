//! What names mean: a module's own declarations, its imports, and paths written in code.

use std::collections::BTreeMap;

use wgsl_parse::syntax::{
    GlobalDeclaration, Import, ImportContent, ImportItem, ImportStatement, ModulePath, PathOrigin,
};

use crate::{Cause, Fault, Library, error::nearest, source::Source, translate::Translated};

/// A declaration of a module.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct Item {
    pub(crate) module: usize,
    pub(crate) name: String,
}

/// What an imported name stands for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Meaning {
    Item(Item),
    /// A module, for paths that start with its name.
    Module(usize),
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

/// What `module`'s imports bring into scope.
pub(crate) fn imports(
    library: &Library,
    module: usize,
    translated: &Translated,
    translations: &mut dyn Translations,
) -> Result<BTreeMap<String, Meaning>, Fault> {
    let source = library.source(module);
    let mut scope: BTreeMap<String, (Meaning, String)> = BTreeMap::new();
    for statement in &translated.imports {
        for (segments, item) in flatten(library, source, statement)? {
            let local = item.rename.as_ref().unwrap_or(&item.ident).name().clone();
            let meaning = resolve(library, source, &segments, translations)?;
            let written = segments.join("::");
            if let Some((other, path)) = scope.get(&local)
                && *other != meaning
            {
                let message = format!("`{local}` is imported from both `{path}` and `{written}`");
                return Err(Fault::new(Cause::Import, message)
                    .at(source.find(&local))
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

/// The absolute path of each item that `statement` imports, from its package on.
fn flatten<'a>(
    library: &Library,
    source: &Source,
    statement: &'a ImportStatement,
) -> Result<Vec<(Vec<String>, &'a ImportItem)>, Fault> {
    let prefix = match &statement.path {
        Some(path) => absolute(library, source, path)?,
        None => Vec::new(),
    };
    let mut items = Vec::new();
    collect(&prefix, &statement.content, &mut items);
    for (segments, _) in &items {
        // Without a path before it, a list's first names are packages.
        if statement.path.is_none() {
            let first = &segments[0];
            if library.package_name(source.package, first).is_none() {
                return Err(no_package(library, source, first));
            }
        }
    }
    Ok(items)
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
fn absolute(library: &Library, source: &Source, path: &ModulePath) -> Result<Vec<String>, Fault> {
    let mut segments = match &path.origin {
        PathOrigin::Absolute => vec![library.own_package_name(source.package).to_owned()],
        PathOrigin::Relative(up) => parent(source, *up)?,
        PathOrigin::Package(name) => match library.package_name(source.package, name) {
            Some(name) => vec![name.to_owned()],
            None => return Err(no_package(library, source, name)),
        },
    };
    segments.extend(path.components.iter().cloned());
    Ok(segments)
}

/// The path of `source`, `up` levels less.
fn parent(source: &Source, up: usize) -> Result<Vec<String>, Fault> {
    let mut segments: Vec<_> = source.path.split("::").map(str::to_owned).collect();
    if up >= segments.len() {
        let message = format!(
            "`super` leaves the package: `{}` is not so deep",
            source.path
        );
        return Err(Fault::new(Cause::Import, message).at(source.find("super")));
    }
    segments.truncate(segments.len() - up);
    Ok(segments)
}

/// What a path written in code stands for: its first name may be an imported module.
pub(crate) fn written_path(
    library: &Library,
    source: &Source,
    scope: &BTreeMap<String, Meaning>,
    segments: &[&str],
    translations: &mut dyn Translations,
) -> Result<Item, Fault> {
    let [first, rest @ ..] = segments else {
        return Err(Fault::new(Cause::Import, "an empty path"));
    };
    let supers = segments
        .iter()
        .take_while(|segment| **segment == "super")
        .count();
    let mut path = match (*first, scope.get(*first)) {
        ("package", _) => vec![library.own_package_name(source.package).to_owned()],
        ("super", _) => parent(source, supers)?,
        ("self", _) => parent(source, 0)?,
        (_, Some(Meaning::Module(module))) => library
            .source(*module)
            .path
            .split("::")
            .map(str::to_owned)
            .collect(),
        (name, _) => match library.package_name(source.package, name) {
            Some(name) => vec![name.to_owned()],
            None => {
                return Err(no_package(library, source, name).note(
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
    match resolve(library, source, &path, translations)? {
        Meaning::Item(item) => Ok(item),
        Meaning::Module(_) => {
            let message = format!("`{}` is a module, not a declaration", segments.join("::"));
            Err(Fault::new(Cause::Import, message).note("name something in it"))
        }
    }
}

/// What the absolute path `segments` stands for: a declaration of a module, or a module.
fn resolve(
    library: &Library,
    source: &Source,
    segments: &[String],
    translations: &mut dyn Translations,
) -> Result<Meaning, Fault> {
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
                .at(source.find(name));
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
            return Err(match nearest(name, names.iter().map(String::as_str)) {
                Some(near) => fault.note(format!("did you mean `{near}`?")),
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
            Err(library
                .no_module(Cause::Import, named)
                .at(source.find(last)))
        }
    }
}

fn no_package(library: &Library, source: &Source, name: &str) -> Fault {
    let packages: Vec<_> = library.package_names().collect();
    let fault = Fault::new(Cause::Import, format!("no package `{name}`")).at(source.find(name));
    match nearest(name, packages.iter().copied()) {
        Some(near) => fault.note(format!("did you mean `{near}`?")),
        None => fault.note(format!("packages: {}", packages.join(", "))),
    }
}

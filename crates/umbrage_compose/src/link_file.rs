//! Linking one file: all that it declares, and what that reaches.

use std::{collections::BTreeSet, path::Path};

use umbrage_hints::did_you_mean;
use wgsl_parse::lexer::Token;

use crate::{
    Cause, Composer, Error, Fault, Library, Package, Permutation, Target, features::FeatureNames,
    file::SourceText, library::Request, names,
};

/// Links all that `file` declares and what that reaches, under `features`, with each interface of
/// `bindings` bound to a module (`interface::shadow` to `methods::basic`; a package's name may stand
/// before). `package` is the folder of the package that `package::` means in the file; without it,
/// the file's own folder.
///
/// Aliases, constants without a concrete type (`const A = 1;`) and assertions, which naga's IR does not keep, are folded
/// into what uses them, and not printed.
///
/// A module's diagnostic directives hold for that module's functions: they are printed as directives where all
/// functions agree, and as attributes of functions otherwise. Attributes of statements become attributes of the
/// blocks within; where a statement's condition needs one, it goes on the block around the statement.
///
/// # Errors
/// Faults in the modules, features that nothing reads, and modules that do not exist.
pub fn link_file(
    file: &Path,
    package: Option<&Path>,
    features: &[String],
    bindings: &[(String, String)],
    target: Target,
) -> Result<Permutation, Error> {
    let source = SourceText::read(file)?;
    let folder = file
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty());
    let dir = package.or(folder).unwrap_or(Path::new("."));
    let name = package_name(dir);
    let mut loaded = Package::load(&name, dir)?;
    let inside = loaded
        .modules
        .iter()
        .find(|(_, module)| same_file(Path::new(&module.file), file));
    let path = match inside {
        Some((path, _)) => path.clone(),
        None => loaded.add(Path::new(file.file_name().unwrap_or_default()), source)?,
    };
    // A package that others extend knows its features from its axes; one file may have any.
    loaded.axes = None;
    let library = Library::new([loaded])?;
    let read_features = mentioned(&library)?;
    for feature in features {
        if !read_features.contains(feature) {
            let fault = Fault::new(
                Cause::Key,
                format!("no module reads the feature `{feature}`"),
            );
            let hint = did_you_mean(feature, read_features.iter().map(String::as_str));
            return Err(match hint {
                Some(hint) => fault.note(hint).into(),
                None => fault.into(),
            });
        }
    }
    let library =
        library.with_features(FeatureNames::new(read_features.iter().map(String::as_str)));
    let module = |path: &str| {
        let path = path.strip_prefix("package::").unwrap_or(path);
        let found = library
            .module(path)
            .or_else(|| library.module(&format!("{name}::{path}")));
        found.ok_or_else(|| library.no_module(Cause::Key, &format!("{name}::{path}")))
    };
    let mut request = Request {
        root: module(&path)?,
        ..Request::default()
    };
    for (interface, implementation) in bindings {
        let interface = module(interface)?;
        if !library.source(interface).is_interface() {
            let message = format!("`{}` is no interface", library.source(interface).path);
            return Err(Fault::new(Cause::Interface, message)
                .note("interfaces lie in their package's folder `interface`")
                .into());
        }
        request.bindings.insert(interface, module(implementation)?);
    }
    for feature in features {
        if let Some(number) = library.features().number(feature) {
            request.features.insert(number);
        }
    }
    Ok(Composer::new(library, target).link_declarations(&request)?)
}

/// Name of the folder `dir`, changed where needed so that paths can begin with it.
fn package_name(dir: &Path) -> String {
    let full = dir.canonicalize().unwrap_or_else(|_| dir.to_owned());
    let name = full.file_name().unwrap_or_default().to_string_lossy();
    let legal = |c: char| c.is_alphanumeric() || c == '_';
    let name: String = (name.chars())
        .map(|c| if legal(c) { c } else { '_' })
        .collect();
    let mut candidates = [name.clone(), format!("folder_{name}")].into_iter();
    candidates
        .find(|name| names::may_stand_in_paths(name))
        .unwrap_or_else(|| "main".to_owned())
}

fn same_file(a: &Path, b: &Path) -> bool {
    match (a.canonicalize(), b.canonicalize()) {
        (Ok(a), Ok(b)) => a == b,
        _ => false,
    }
}

/// The features that some module reads: the words in the conditions of `@if` and `@elif`.
fn mentioned(library: &Library) -> Result<BTreeSet<String>, Fault> {
    let mut features = BTreeSet::new();
    for module in 0..library.sources().len() {
        // A module with a fault is told of where it is needed.
        let Ok(syntax) = library.syntax(module) else {
            continue;
        };
        let mut tokens = syntax.tokens.iter().map(|(token, _)| token).peekable();
        while let Some(token) = tokens.next() {
            let condition = *token == Token::SymAttr
                && match tokens.peek() {
                    Some(Token::KwIf) => true,
                    Some(Token::Ident(name)) => name == "elif",
                    Some(Token::ReservedWord(name)) => name == "elif",
                    _ => false,
                };
            if !condition {
                continue;
            }
            tokens.next();
            let mut depth = 0;
            for token in tokens.by_ref() {
                match token {
                    Token::SymParenLeft => depth += 1,
                    Token::SymParenRight => depth -= 1,
                    Token::Ident(name) => {
                        features.insert(name.clone());
                    }
                    _ => {}
                }
                if depth == 0 {
                    break;
                }
            }
        }
    }
    Ok(features)
}

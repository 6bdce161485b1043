//! A module made ready for naga: what is disabled blanked out, paths made names, and stand-ins
//! appended for what it takes from others.

use std::{
    collections::{BTreeMap, BTreeSet, HashMap},
    ops::Range,
    sync::Arc,
};

use wgsl_parse::{lexer::Token, syntax::GlobalDeclaration};

use crate::{
    Fault, Library,
    diagnostics::Filters,
    extensions::Extensions,
    features::{Consulted, Features},
    names::{self, Item, Meaning, Translations, declared},
    stubs::{self, JOINT, Stubs},
    translate::{Translated, TranslatedModules},
};

/// A module's text, ready for naga.
#[derive(Debug)]
pub(crate) struct Prepared {
    /// The `enable` directives that other modules' declarations need, the author's text with every byte in its
    /// place, and the stand-ins.
    pub(crate) text: String,
    /// The author's part of the text.
    pub(crate) own: Range<usize>,
    /// Extensions enabled for other modules' declarations, and the module that asks for each.
    pub(crate) lent: BTreeMap<String, usize>,
    pub(crate) stubs: Stubs,
    /// The modules that it, or what stands in for others' declarations, takes something from.
    pub(crate) modules: BTreeSet<usize>,
    /// The interfaces of which it takes a function, so that their binding matters.
    pub(crate) interfaces: BTreeSet<usize>,
    /// Names of its own declarations and of those in scope.
    pub(crate) known: Vec<String>,
    /// Imported names that resolve to nothing, each with the fault for its use.
    pub(crate) unknown: BTreeMap<String, Fault>,
    /// The features that the text depends on.
    pub(crate) consulted: Consulted,
    /// The diagnostic filters, which are blanked out of the text.
    pub(crate) filters: Arc<Filters>,
}

/// Prepares `module` under `features`.
pub(crate) fn prepare(
    library: &Library,
    module: usize,
    features: &Features<'_>,
    modules: &TranslatedModules,
) -> Result<Prepared, Fault> {
    let mut translations = Cached {
        library,
        modules,
        features,
        done: HashMap::new(),
        consulted: Consulted::default(),
    };
    let translated = translations.translated(module)?;
    let scope = names::imports(library, module, &translated, &mut translations)?;
    let mut wanted: BTreeMap<String, Item> = BTreeMap::new();
    let mut unknown = BTreeMap::new();
    for (name, meaning) in &scope {
        match meaning {
            Meaning::Item(item) => {
                wanted.insert(name.clone(), item.clone());
            }
            Meaning::Nothing(fault) => {
                unknown.insert(name.clone(), fault.clone());
            }
            Meaning::Module(_) => {}
        }
    }
    let source = library.source(module);
    let tokens = &library.syntax(module)?.tokens;
    let filters = Filters::read(source, tokens, &translated.blanks)?;
    let mut text = source.text.as_bytes().to_vec();
    let extensions = Extensions::read(source, tokens, &translated.blanks);
    let blanks = translated.blanks.iter().cloned().chain(filters.written());
    for range in blanks.chain(extensions.blanks) {
        for byte in &mut text[range] {
            if *byte != b'\n' {
                *byte = b' ';
            }
        }
    }
    for path in written_paths(tokens, &translated.blanks) {
        let segments: Vec<_> = path
            .segments
            .iter()
            .map(|range| &source.text[range.clone()])
            .collect();
        let at = (source, path.range.clone());
        let item = names::written_path(library, at, &scope, &segments, &mut translations).map_err(
            |fault| match fault.locations.is_empty() {
                true => fault.at(source.place(path.range.clone())),
                false => fault,
            },
        )?;
        // Spaces within a path are rare, but the name must be one word all the same.
        for byte in &mut text[path.range.clone()] {
            if byte.is_ascii_whitespace() {
                *byte = b'_';
            }
        }
        for joint in &path.joints {
            text[joint.clone()].copy_from_slice(JOINT.as_bytes());
        }
        let name = String::from_utf8_lossy(&text[path.range.clone()]).into_owned();
        wanted.insert(name, item);
    }
    let stubs = stubs::build(library, module, &wanted, &mut translations)?;
    let declared: Vec<_> = translated
        .declarations
        .iter()
        .filter_map(|d| declared(d))
        .collect();
    // Whole characters were blanked, so this changes nothing.
    let own_text = String::from_utf8_lossy(&text);
    let mut lent = BTreeMap::new();
    let modules: BTreeSet<_> = stubs.items.values().map(|item| item.module).collect();
    for &other in &modules {
        let blanks = &translations.translated(other)?.blanks;
        let tokens = &library.syntax(other)?.tokens;
        let asked = Extensions::read(library.source(other), tokens, blanks).enabled;
        lent.extend(asked.into_iter().map(|name| (name, other)));
    }
    lent.retain(|name, _| !extensions.enabled.contains(name));
    let mut text: String = lent
        .keys()
        .map(|name| format!("enable {name};\n"))
        .collect();
    let own = text.len()..text.len() + own_text.len();
    text.push_str(&own_text);
    text.push('\n');
    text.push_str(&stubs.text);
    let mut interfaces = BTreeSet::new();
    for item in wanted.values() {
        if library.source(item.module).is_interface()
            && is_function(&*translations.translated(item.module)?, &item.name)
        {
            interfaces.insert(item.module);
        }
    }
    Ok(Prepared {
        known: (declared.iter().chain(scope.keys()))
            .filter(|name| !unknown.contains_key(*name))
            .cloned()
            .collect(),
        unknown,
        modules,
        text,
        own,
        lent,
        stubs,
        interfaces,
        consulted: translations.consulted,
        filters: Arc::new(filters),
    })
}

fn is_function(translated: &Translated, name: &str) -> bool {
    translated.declarations.iter().any(|node| {
        matches!(node.node(), GlobalDeclaration::Function(function) if *function.ident.name() == name)
    })
}

/// Translations under some features, and what they consulted.
struct Cached<'a> {
    library: &'a Library,
    modules: &'a TranslatedModules,
    features: &'a Features<'a>,
    done: HashMap<usize, Arc<Translated>>,
    consulted: Consulted,
}

impl Translations for Cached<'_> {
    fn translated(&mut self, module: usize) -> Result<Arc<Translated>, Fault> {
        if let Some(done) = self.done.get(&module) {
            return Ok(done.clone());
        }
        let translated = self.modules.get(self.library, module, self.features)?;
        self.consulted.union(&translated.consulted);
        self.done.insert(module, translated.clone());
        Ok(translated)
    }
}

/// A path written in code, such as `package::common::math::square`.
struct WrittenPath {
    range: Range<usize>,
    segments: Vec<Range<usize>>,
    joints: Vec<Range<usize>>,
}

fn written_paths(tokens: &[(Token, Range<usize>)], blanks: &[Range<usize>]) -> Vec<WrittenPath> {
    let mut paths = Vec::new();
    let mut index = 0;
    while index + 2 < tokens.len() {
        let start = &tokens[index].1;
        let is_path = tokens[index + 1].0 == Token::SymColonColon;
        let mut blanks = blanks.iter();
        if !is_path || blanks.any(|blank| blank.start <= start.start && start.end <= blank.end) {
            index += 1;
            continue;
        }
        let mut path = WrittenPath {
            range: start.clone(),
            segments: vec![start.clone()],
            joints: Vec::new(),
        };
        while index + 2 < tokens.len() && tokens[index + 1].0 == Token::SymColonColon {
            path.joints.push(tokens[index + 1].1.clone());
            path.segments.push(tokens[index + 2].1.clone());
            index += 2;
        }
        path.range.end = tokens[index].1.end;
        paths.push(path);
        index += 1;
    }
    paths
}

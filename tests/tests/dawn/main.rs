//! Verdicts on what WebGPU takes and refuses: ours held against Dawn's.
//!
//! `dawn/shaders` has small shaders, one a file, whose first line says what Dawn says of it (`// Dawn: takes it`,
//! or `// Dawn: refuses it: WHY`), so that ours are held to it where no Dawn is. A second line `// Umbrage: WORDS`
//! asks that we refuse it in these words; every shader that Dawn refuses has one, and one that Dawn takes has it
//! where naga cannot do it. `UMBRAGE_BLESS=1` writes the first lines anew, by Dawn.
#![allow(
    clippy::panic,
    reason = "a test's helpers may fail it, with the error's own words"
)]

mod random;

use std::{
    fs,
    path::{Path, PathBuf},
};

use rayon::prelude::*;
use umbrage::compose::{Composer, Library, Limit, Package, Target};
use umbrage_tests::{Dawn, covering};

/// A stored shader.
struct Shader {
    path: PathBuf,
    text: String,
}

impl Shader {
    /// Why Dawn refuses it, by its first line; none where it takes it.
    fn stored(&self) -> Option<&str> {
        let line = self.text.lines().next().unwrap_or("");
        match line.strip_prefix("// Dawn: refuses it: ") {
            Some(why) => Some(why),
            None if line == "// Dawn: takes it" => None,
            None => panic!(
                "{}: the first line must say what Dawn says; UMBRAGE_BLESS=1 writes it",
                self.path.display()
            ),
        }
    }

    /// The words that our refusal must have.
    fn words(&self) -> Option<&str> {
        self.text.lines().nth(1)?.strip_prefix("// Umbrage: ")
    }
}

fn shaders() -> Vec<Shader> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("dawn/shaders");
    let mut folders = vec![root];
    let mut shaders = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "wgsl") {
                let text = fs::read_to_string(&path).expect("a text");
                shaders.push(Shader { path, text });
            }
        }
    }
    shaders.sort_by(|a, b| a.path.cmp(&b.path));
    assert!(!shaders.is_empty());
    shaders
}

/// Why we refuse the shader `text` for WebGPU; none where we take it.
fn our_refusal(text: &str) -> Option<String> {
    our_refusal_of(&[("main.wesl", text)])
}

/// The same of a package of `files`, the first of which is the pass.
fn our_refusal_of(files: &[(&str, &str)]) -> Option<String> {
    let axes = r#"(axes: {
        "pass": (values: { "main": (root: "package::main") }),
        "hue": (default: "none", values: {
            "none": (), "coloured": (features: ["COLOURED"]), "grey": (features: ["GREY"]),
        }),
    })"#;
    let files = files.iter().copied().chain([("axes.ron", axes)]);
    let files = files.map(|(path, text)| (path.to_owned(), text.to_owned()));
    let composed = Package::from_sources("demo", "demo", files)
        .and_then(|package| Library::new([package]))
        .and_then(|library| {
            let hues = ["none", "coloured", "grey"]
                .map(|hue| library.key([("pass", "main"), ("hue", hue)]));
            let composer = Composer::new(library, Target::webgpu());
            for key in hues {
                composer.compose(&key?)?;
            }
            Ok(())
        });
    composed.err().map(|error| error.to_string())
}

/// We take or refuse every stored shader as Dawn does, by the verdict stored with it.
#[test]
fn our_verdicts_are_the_stored_ones() {
    let wrong: Vec<_> = shaders()
        .par_iter()
        .filter_map(|shader| {
            let path = shader.path.display();
            match (shader.stored(), shader.words(), our_refusal(&shader.text)) {
                (None, None, None) => None,
                (_, Some(words), Some(ours)) if ours.contains(words) => None,
                (dawns, words, ours) => Some(format!(
                    "{path}: Dawn says {dawns:?}, we are to say {words:?}, and say\n{}",
                    ours.as_deref().unwrap_or("nothing against it")
                )),
            }
        })
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// The verdicts stored with the shaders are Dawn's.
#[test]
fn the_stored_verdicts_are_dawns() {
    let bless = std::env::var_os("UMBRAGE_BLESS").is_some();
    let Some(mut dawn) = Dawn::start() else {
        return;
    };
    let mut wrong = Vec::new();
    for shader in shaders() {
        let line = match dawn.refusal(&shader.text) {
            Some(why) => {
                let why = why.lines().next().unwrap_or("").trim();
                let place = why
                    .split_once(' ')
                    .filter(|(place, _)| place.chars().all(|c| c.is_ascii_digit() || c == ':'));
                // The place is left out: it tells nothing that the text does not.
                let why = place.map_or(why, |(_, why)| why);
                format!("// Dawn: refuses it: {why}")
            }
            None => "// Dawn: takes it".to_owned(),
        };
        let (first, rest) = shader.text.split_once('\n').unwrap_or((&shader.text, ""));
        if first == line {
            continue;
        }
        if bless {
            let rest = if first.starts_with("// Dawn: ") {
                rest
            } else {
                &shader.text
            };
            fs::write(&shader.path, format!("{line}\n{rest}")).expect("written");
        } else {
            wrong.push(format!("{}: {line}", shader.path.display()));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Dawn takes our library's permutations, as we do: a cover of the space.
#[test]
fn our_permutations_are_taken_by_dawn() {
    let Some(mut dawn) = Dawn::start() else {
        return;
    };
    let library = umbrage::shader_library().unwrap_or_else(|error| panic!("{error}"));
    let composer = Composer::new(library, Target::webgpu());
    let keys = covering(&composer).unwrap_or_else(|error| panic!("{error}"));
    let texts: Vec<_> = keys
        .par_iter()
        .map(|key| {
            let composed = composer.compose(key);
            let text = composed.and_then(|composed| composed.permutation.wgsl());
            (key, text.unwrap_or_else(|error| panic!("{error}")))
        })
        .collect();
    let refused: Vec<_> = texts
        .iter()
        .filter_map(|(key, text)| Some(format!("{key}: {}", dawn.refusal(text)?)))
        .collect();
    assert!(
        refused.is_empty(),
        "{} of {} permutations:\n{}",
        refused.len(),
        texts.len(),
        refused.join("\n")
    );
}

/// The rows of the page that says what is supported, cell by cell.
fn rows(page: &str) -> Vec<Vec<&str>> {
    let rows = page.lines().filter(|line| line.starts_with("| "));
    rows.map(|row| row.trim_matches('|').split('|').map(str::trim).collect())
        .collect()
}

/// The composer's page on WGSL and WESL is true: each row's shader is taken, or refused, as the row says.
#[test]
fn the_page_of_what_is_supported_is_so() {
    let home = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = home.join("../crates/umbrage_compose/support.md");
    let page = fs::read_to_string(page).expect("a page");
    let shapes = fs::read_to_string(home.join("wesl/shapes.wesl")).expect("a text");
    let mut shown = 0;
    let mut wrong = Vec::new();
    for row in rows(&page) {
        let [what, taken, shader] = row.as_slice() else {
            continue;
        };
        let Some(path) = shader
            .strip_prefix('`')
            .and_then(|path| path.strip_suffix('`'))
        else {
            continue;
        };
        shown += 1;
        let (ours, dawns) = if path.starts_with("wesl/") {
            let text = fs::read_to_string(home.join(path)).expect(path);
            let ours = our_refusal_of(&[("main.wesl", &text), ("shapes.wesl", &shapes)]);
            // Dawn does not know WESL.
            (ours.clone(), ours)
        } else {
            let path = home.join("dawn/shaders").join(path);
            let text = fs::read_to_string(&path).expect("a text");
            let shader = Shader { path, text };
            (
                our_refusal(&shader.text),
                shader.stored().map(str::to_owned),
            )
        };
        let is = match (ours.is_none(), dawns.is_none()) {
            (true, true) => "yes",
            (false, false) => "no",
            (false, true) => "not by naga",
            (true, false) => "by us alone",
        };
        if is != *taken {
            wrong.push(format!(
                "{what}: {taken}, but {is}: {}",
                ours.unwrap_or_default()
            ));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(shown > 40, "{shown}");
}

/// The page has every limit with its value, and a stored shader exceeds each of them.
#[test]
fn every_limit_is_on_the_page_and_is_held() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates/umbrage_compose/support.md");
    let page = fs::read_to_string(page).expect("a page");
    let shaders = shaders();
    for limit in Limit::ALL {
        let row = format!("| `{}` | {} |", limit.name(), limit.webgpu());
        assert!(page.contains(&row), "{row}");
        let beyond = |shader: &Shader| shader.words() == Some(limit.name());
        assert!(
            shaders.iter().any(beyond),
            "no shader is beyond {}",
            limit.name()
        );
    }
    let limits = rows(&page)
        .iter()
        .filter(|row| row[0].starts_with("`max"))
        .count();
    assert_eq!(limits, Limit::ALL.len());
}

/// How many shaders are made at random.
const RANDOM: u64 = 2000;

/// Of shaders made at random, at the borders of the rules, we take and refuse the same as Dawn.
#[test]
fn random_shaders_are_judged_alike() {
    let Some(mut dawn) = Dawn::start() else {
        return;
    };
    // Runs by hand may choose other shaders, or more of them.
    let number = |name: &str| std::env::var(name).ok().and_then(|n| n.parse().ok());
    let first: u64 = number("UMBRAGE_FIRST_SEED").unwrap_or(0);
    let count = number("UMBRAGE_SEEDS").unwrap_or(RANDOM);
    let judged: Vec<_> = (first..first + count)
        .into_par_iter()
        .map(|seed| {
            let text = random::shader(seed);
            (seed, our_refusal(&text), text)
        })
        .collect();
    let mut refused = 0;
    let mut wrong = Vec::new();
    for (seed, ours, text) in judged {
        let dawns = dawn.refusal(&text);
        refused += u32::from(dawns.is_some());
        // Naga evaluates few functions of constants that have no type; we say so where it does not.
        let untyped = ours
            .as_ref()
            .is_some_and(|ours| ours.contains("naga does not evaluate"));
        if !untyped && ours.is_some() != dawns.is_some() {
            wrong.push(format!("{seed}: Dawn says {dawns:?}, we {ours:?}\n{text}"));
        }
    }
    // A generator that made only valid, or only invalid, shaders would test nothing.
    assert!(
        refused > count as u32 / 5 && refused < count as u32 * 4 / 5,
        "{refused}"
    );
    assert!(
        wrong.is_empty(),
        "{} of {count}, of which {refused} are refused:\n{}",
        wrong.len(),
        wrong.join("\n")
    );
}

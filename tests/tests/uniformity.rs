//! Uniformity, on random shaders: our verdicts held against Dawn's, which are stored as `dawn/random_uniformity.txt`: a
//! character a shader, in the order of their numbers, `+` where Dawn takes it and `-` where it refuses it.
//! `UMBRAGE_BLESS=1` writes them anew, by Dawn.
#![allow(
    clippy::panic,
    reason = "a test's helpers may fail it, with the error's own words"
)]

use std::{fs, path::PathBuf};

use rayon::prelude::*;
use umbrage::compose::{Error, Target, link_file};
use umbrage_tests::{Dawn, random_shader};

/// How many shaders.
const SHADERS: u64 = 2000;

fn stored() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("dawn/random_uniformity.txt")
}

/// The stored verdicts: whether Dawn takes each shader.
fn verdicts() -> Vec<bool> {
    let text = fs::read_to_string(stored()).expect("the stored verdicts");
    let marks = text.chars().filter(|mark| !mark.is_whitespace());
    marks.map(|mark| mark == '+').collect()
}

/// The WGSL that we print for the shader `seed`: of all its functions, as Dawn also checks those that nothing calls.
fn linked(seed: u64) -> Result<String, Error> {
    let thread = std::thread::current().id();
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("{seed}-{thread:?}"));
    fs::create_dir_all(&folder).expect("a folder");
    let file = folder.join("main.wgsl");
    fs::write(&file, random_shader(seed)).expect("a file");
    let linked = link_file(&file, None, &[], &[], Target::webgpu());
    fs::remove_dir_all(&folder).expect("removed");
    linked?.wgsl()
}

/// We take or refuse random shaders as Dawn does.
#[test]
fn random_shaders_are_taken_as_dawn_takes_them() {
    let verdicts = verdicts();
    assert_eq!(verdicts.len() as u64, SHADERS);
    let taken = verdicts.iter().filter(|taken| **taken).count();
    assert!(taken > 500 && verdicts.len() - taken > 500, "one-sided");
    let wrong: Vec<_> = verdicts
        .into_par_iter()
        .enumerate()
        .filter_map(|(seed, taken)| {
            let text = random_shader(seed as u64);
            match (taken, linked(seed as u64)) {
                (true, Err(error)) => Some(format!("{seed}: Dawn takes it\n{text}\n{error}")),
                (false, Ok(_)) => Some(format!("{seed}: Dawn refuses it\n{text}")),
                // These shaders have faults of this kind only.
                (false, Err(error)) if !error.to_string().contains("uniform") => Some(format!(
                    "{seed}: refused for another reason\n{text}\n{error}"
                )),
                _ => None,
            }
        })
        .collect();
    assert!(wrong.is_empty(), "{}: {}", wrong.len(), wrong[0]);
}

/// The stored verdicts are Dawn's, and Dawn takes what we print of the shaders that it takes.
#[test]
fn dawn_takes_what_we_print_of_random_shaders() {
    let bless = std::env::var_os("UMBRAGE_BLESS").is_some();
    let Some(mut dawn) = Dawn::start() else {
        return;
    };
    let refused: Vec<_> = (0..SHADERS)
        .map(|seed| dawn.refusal(&random_shader(seed)))
        .collect();
    if bless {
        let mut text = String::new();
        for line in refused.chunks(100) {
            let mark = |refusal: &Option<String>| if refusal.is_none() { '+' } else { '-' };
            text.extend(line.iter().map(mark));
            text.push('\n');
        }
        fs::write(stored(), text).expect("written");
    }
    for ((seed, refusal), taken) in refused.iter().enumerate().zip(verdicts()) {
        assert_eq!(refusal.is_none(), taken, "{seed}: {refusal:?}");
        let uniform = |why: &String| why.contains("uniform");
        assert!(refusal.as_ref().is_none_or(uniform), "{seed}: {refusal:?}");
        if let Ok(text) = linked(seed as u64) {
            assert_eq!(dawn.refusal(&text), None, "{seed}: {text}");
        }
    }
}

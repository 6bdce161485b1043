//! The example's picture, and its length.

use std::{path::Path, process::Command};

use umbrage_testkit::pictures;

#[test]
fn it_draws_its_picture() {
    let drawn = Path::new(env!("CARGO_TARGET_TMPDIR")).join("blocks.png");
    let mut command = Command::new(env!("CARGO_BIN_EXE_umbrage_example_own_renderer"));
    let output = command.arg(&drawn).output().expect("it runs");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    let picture = image::open(&drawn).expect("a picture").into_rgb8();
    let reference = Path::new(env!("CARGO_MANIFEST_DIR")).join("blocks.png");
    assert_eq!(pictures::check(&picture, &reference), Ok(()));
}

/// A renderer needs little to have shadows: what its page promises who reads it.
#[test]
fn it_is_small() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let lines = |path: &str| {
        let text = std::fs::read_to_string(folder.join(path)).expect("a file");
        text.lines().count()
    };
    assert!(lines("src/main.rs") <= 150, "{}", lines("src/main.rs"));
    assert!(lines("shaders/blocks.wesl") <= 40);
}

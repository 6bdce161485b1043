//! RADV's figures, and what happens where it gives none. Where RADV is missing these tests fail, and say what
//! to install: it comes with Mesa's Vulkan drivers, which rendering without a GPU needs anyhow.

mod budget;
mod figures;
mod trouble;

use std::sync::{Arc, LazyLock};

use umbrage_compose::{Composer, Library, Package, Permutation, Target};
use umbrage_isa::{Compiler, CompilerOptions, PipelineState, StageCost};

/// The process that a compiler starts: this program again, with this test alone.
#[test]
fn server() {
    umbrage_isa::serve_if_asked();
}

/// Options to compile for `family` by the test called `server`.
fn options(family: &str, server: &str) -> CompilerOptions {
    CompilerOptions {
        args: ["--exact", server, "--nocapture"].map(Into::into).to_vec(),
        ..CompilerOptions::new(family)
    }
}

fn compiler(family: &str) -> Compiler {
    Compiler::with(&options(family, "server"))
        .map_err(|error| error.to_string())
        .expect("RADV compiles")
}

/// A permutation of Umbrage's own shaders.
fn permutation(choices: &[(&str, &str)]) -> Arc<Permutation> {
    static COMPOSER: LazyLock<Composer> = LazyLock::new(|| {
        let package = umbrage_shader_lib::package().expect("it loads");
        let library = Library::new([package]).expect("a library");
        Composer::new(library, Target::webgpu())
    });
    let key = COMPOSER.library().key(choices.iter().copied());
    let composed = COMPOSER.compose(&key.expect("a key")).expect("it links");
    composed.permutation
}

/// The permutation of one module.
fn of_module(text: &str) -> Arc<Permutation> {
    let axes = r#"(axes: { "pass": (values: { "own": (root: "package::own") }) })"#;
    let files = [("axes.ron", axes), ("own.wesl", text)];
    let files = files.map(|(path, text)| (path.to_owned(), text.to_owned()));
    let package = Package::from_sources("demo", "demo", files).expect("it loads");
    let library = Library::new([package]).expect("a library");
    let key = library.key([("pass", "own")]).expect("a key");
    let composer = Composer::new(library, Target::webgpu());
    composer.compose(&key).expect("it links").permutation
}

fn cost(compiler: &mut Compiler, permutation: &Permutation) -> Vec<StageCost> {
    let state = PipelineState::of(permutation);
    compiler.cost(permutation, &state).expect("figures")
}

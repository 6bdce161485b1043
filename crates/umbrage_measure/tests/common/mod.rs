//! Helpers that the tests draw with.

use std::sync::Arc;

use umbrage_compose::{Composer, Library, Target};
use umbrage_render::{Gpu, Renderer};

/// A renderer with the project's shaders and methods.
pub(crate) fn renderer() -> Renderer {
    let package = umbrage_shader_lib::package().expect("the shader library");
    let library = Library::new([package]).expect("the library");
    let composer = Arc::new(Composer::new(library, Target::default()));
    let methods = umbrage_methods::registry().expect("names are unique");
    let gpu = Arc::new(Gpu::new().expect("an adapter"));
    Renderer::new(gpu, composer, methods)
}

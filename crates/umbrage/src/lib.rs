//! Shader permutations and shadow methods for wgpu.

pub use umbrage_compose as compose;
pub use umbrage_methods as methods;
pub use umbrage_render as render;
pub use umbrage_shadow as shadow;

/// Umbrage's own shaders, as a library to compose from: nothing is read from disk.
///
/// # Errors
/// Where the embedded package does not fit together; the project's tests keep it from happening.
pub fn shader_library() -> Result<compose::Library, compose::Error> {
    compose::Library::new([umbrage_shader_lib::package()?])
}

//! Passes as the shader library describes them.

use umbrage_compose::{Depth, Purpose};
use umbrage_wgpu::blend_state;

use super::Renderer;
use crate::RenderError;

/// A pass that is run.
#[derive(Clone, Copy)]
pub(super) struct NamedPass<'a> {
    /// The value of the axis `pass`.
    pub(super) name: &'a str,
    pub(super) purpose: Purpose,
    /// How its colours meet those that are there; without it, they take their place.
    pub(super) blend: Option<wgpu::BlendState>,
    /// Whether its depth takes the place of what is there.
    pub(super) writes_depth: bool,
}

impl Renderer {
    /// The renderer's own pass `name`.
    ///
    /// # Errors
    /// A shader library that does not tell how it is run.
    pub(super) fn pass<'a>(&self, name: &'a str) -> Result<NamedPass<'a>, RenderError> {
        let axis = self.composer.library().axes().get("pass");
        let pass = axis.and_then(|axis| axis.pass(name));
        let pass = pass.ok_or_else(|| RenderError::Axis {
            place: "the renderer".to_owned(),
            axis: "pass".to_owned(),
            problem: format!(
                "but the shader library does not tell how `{name}` is run: give that value a root and a `pass`"
            ),
        })?;
        Ok(NamedPass {
            name,
            purpose: pass.purpose,
            blend: blend_state(pass.blend),
            writes_depth: pass.depth == Depth::Written,
        })
    }
}

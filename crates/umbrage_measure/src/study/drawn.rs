//! Work in shadow maps that no load of the machine changes.

use umbrage_render::Report;
use umbrage_shadow::{Pass, ShadowPlan};

/// Work of the passes of a picture's plans, all lights together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Drawn {
    /// Texels that passes fill, in each of their targets: a texel that two passes fill counts twice.
    pub(super) texels: u64,
    /// Triangles of casters.
    pub(super) triangles: u64,
    /// Vertices of casters, each once for each pass that it is drawn in.
    pub(super) vertices: u64,
}

impl Drawn {
    /// Of a picture whose maps were all drawn.
    pub(super) fn of(report: &Report) -> Self {
        let plans = report.plans.iter().flatten();
        let passes = plans.flat_map(|plan| plan.passes.iter().map(|pass| texels(plan, pass)));
        Self {
            texels: passes.sum(),
            triangles: report.caster_triangles,
            vertices: report.caster_vertices,
        }
    }
}

/// How many texels a pass fills: its viewport in each target, or all that a compute shader's textures hold.
fn texels(plan: &ShadowPlan, pass: &Pass) -> u64 {
    let (targets, viewport) = match pass {
        Pass::Casters(pass) => {
            let targets = pass.colors.len() + usize::from(pass.depth.is_some());
            (targets, &pass.viewport)
        }
        Pass::Screen(pass) => (pass.targets.len(), &pass.viewport),
        Pass::Compute(pass) => {
            let outputs = pass.writes.iter().filter_map(|written| {
                let mut textures = plan.textures.iter();
                let texture = textures.find(|texture| texture.name == written.name)?;
                let level = written.level.unwrap_or(0);
                let layers = written.layer.map_or(texture.shape.layers(), |_| 1);
                let side = |size: u32| (size >> level).max(1);
                Some(u64::from(layers) * area(side(texture.width), side(texture.height)))
            });
            return outputs.sum();
        }
        // A kind of pass that is newer than this.
        _ => return 0,
    };
    targets as u64 * area(viewport.width, viewport.height)
}

fn area(width: u32, height: u32) -> u64 {
    u64::from(width) * u64::from(height)
}

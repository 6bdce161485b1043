//! Variables between a vertex and a fragment stage that the permutation's target takes, and another of the crate's tables
//! does not: the shader is one short step from not being portable.

use std::sync::OnceLock;

use naga::ShaderStage;

use super::{Lint, Linted, linted};
use crate::{Permutation, Target, diagnostics::Places, rules::locations_given, target::Limit};

pub(super) fn check(
    permutation: &Permutation,
    places: &Places<'_>,
    (target, root): (&Target, usize),
    found: &mut Vec<Linted>,
) {
    let (most, least) = least();
    let entries = permutation.module.entry_points.iter();
    for entry in entries.filter(|entry| entry.stage == ShaderStage::Vertex) {
        let count = locations_given(&permutation.module, entry);
        let place = places.library.source(root).find(&entry.name);
        let filters = places.filters.get(&root);
        let is_off = filters.is_some_and(|filters| {
            super::is_off(filters, Lint::TooManyVaryings, place.range.start)
        });
        if count > *most && *least != target.name() && !is_off {
            let message = format!(
                "`{}` hands on variables at {count} locations, but the target `{least}` takes {most}",
                entry.name
            );
            let advice = "use fewer, or pack them together";
            found.push(linted(Lint::TooManyVaryings, place, message, advice));
        }
    }
}

/// The least number of variables that a target takes, and the target.
fn least() -> &'static (u64, &'static str) {
    static LEAST: OnceLock<(u64, &'static str)> = OnceLock::new();
    LEAST.get_or_init(|| {
        let limits = Target::names().filter_map(|name| {
            let target = Target::named(name).ok()?;
            Some((target.limit(Limit::InterStageShaderVariables), name))
        });
        limits.min().unwrap_or((u64::MAX, ""))
    })
}

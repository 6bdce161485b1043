//! Bindings that no permutation of the space uses, though the modules that declare them are part of some: a host would
//! never be asked for them.

use super::{Lint, Linted, linted};
use crate::Composer;

pub(super) fn check(composer: &Composer, found: &mut Vec<Linted>) {
    let library = composer.library();
    let used = composer.used();
    for (module, name) in composer.declared_bindings() {
        let source = library.source(module);
        let place = source.find(&name);
        if used.contains(&(module as u32, library.number(&name)))
            || composer.is_off(module, Lint::UnusedBinding, place.range.start)
        {
            continue;
        }
        let message = format!("no permutation uses the binding `{name}`");
        let advice = "remove it, or use it where its module is meant to";
        found.push(linted(Lint::UnusedBinding, place, message, advice));
    }
}

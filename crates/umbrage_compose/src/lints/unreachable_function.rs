//! Functions of interfaces that no permutation of the space calls: every implementation must have them, for nothing.

use super::{Lint, Linted, linted};
use crate::Composer;

pub(super) fn check(composer: &Composer, found: &mut Vec<Linted>) {
    let library = composer.library();
    let called = composer.called();
    for &interface in library.interfaces() {
        let source = library.source(interface);
        let Ok(contract) = library.syntax(interface) else {
            continue;
        };
        for name in &contract.functions {
            let place = source.find(name);
            if called.contains(&(interface as u32, library.number(name)))
                || composer.is_off(interface, Lint::UnreachableFunction, place.range.start)
            {
                continue;
            }
            let message = format!(
                "no permutation calls `{name}` of the interface `{}`",
                source.path
            );
            let advice =
                "remove it from the interface and from what implements it, or let a module call it";
            found.push(linted(Lint::UnreachableFunction, place, message, advice));
        }
    }
}

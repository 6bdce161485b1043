//! Capabilities: why two values of different axes may go together, or not, though neither names the other.
//!
//! A value *provides* capabilities (a spot light: a map on a plane) and *needs* some (a filter that blurs maps needs one
//! on a plane). A combination is legal where each need of each chosen value is provided by a chosen value, so a new
//! value changes nothing in the others' descriptions.

use std::collections::BTreeSet;

use umbrage_hints::did_you_mean;

use crate::{Axes, Cause, Fault, axes::Effect};

/// A fault of the axes' capabilities, and the words in a package's `axes.ron` that lead to its place.
pub(crate) struct Misuse {
    pub(crate) fault: Fault,
    pub(crate) path: Vec<String>,
}

/// Checks that each capability is declared, provided and needed, and that no needs go in a circle.
pub(crate) fn check(axes: &Axes) -> Result<(), Misuse> {
    let values = || {
        axes.iter().flat_map(|axis| {
            let values = axis.values.iter();
            values.map(move |(value, effect)| (&*axis.name, &**value, effect))
        })
    };
    for (axis, value, effect) in values() {
        let lists = [("provides", &effect.provides), ("needs", &effect.needs)];
        for (list, names) in lists {
            for name in names {
                if axes.capabilities().all(|known| known != name) {
                    let message = format!("no capability `{name}` is declared");
                    return Err(misuse(message, [axis, value, list, name]).note(
                        match did_you_mean(name, axes.capabilities()) {
                            Some(hint) => hint,
                            None => {
                                format!("say what it is under `capabilities`: \"{name}\": \"...\"")
                            }
                        },
                    ));
                }
            }
        }
    }
    for name in axes.capabilities() {
        let users = |list: fn(&Effect) -> &Vec<String>| {
            let has = move |effect: &Effect| list(effect).iter().any(|known| known == name);
            values().filter(move |(_, _, effect)| has(effect))
        };
        let provider = users(|effect| &effect.provides).next();
        let needer = users(|effect| &effect.needs).next();
        match (provider, needer) {
            (Some(_), Some(_)) => {}
            (None, Some((axis, value, _))) => {
                let message = format!("{axis}={value} needs `{name}`, which no value provides");
                return Err(misuse(message, [axis, value, "needs", name])
                    .note("let some value provide it, or remove the need"));
            }
            (Some((axis, value, _)), None) => {
                let message = format!("{axis}={value} provides `{name}`, which no value needs");
                return Err(misuse(message, [axis, value, "provides", name])
                    .note("remove it, or let a value need it"));
            }
            (None, None) => {
                let message = format!("no value provides or needs the capability `{name}`");
                return Err(misuse(message, ["capabilities", name]).note("remove it"));
            }
        }
    }
    for (axis, value, effect) in values() {
        if let Some(circle) = circle(axes, effect) {
            let message = format!(
                "needs go in a circle: {axis}={value} provides `{}`, and with it needs `{}`",
                circle.join("`, whose providers need `"),
                circle[0]
            );
            return Err(misuse(message, [axis, value, "provides", &circle[0]]).note(
                "what a value provides must not depend on itself: remove one of these needs",
            ));
        }
    }
    Ok(())
}

/// Capabilities from one that `effect` provides, through what it needs and what each provider of that needs, back to
/// the first.
fn circle(axes: &Axes, effect: &Effect) -> Option<Vec<String>> {
    for first in &effect.provides {
        let mut waiting: Vec<Vec<String>> = (effect.needs.iter())
            .map(|need| vec![first.clone(), need.clone()])
            .collect();
        let mut seen = BTreeSet::new();
        while let Some(path) = waiting.pop() {
            let last = path.last()?;
            if last == first {
                return Some(path[..path.len() - 1].to_vec());
            }
            if !seen.insert(last.clone()) {
                continue;
            }
            let all = axes.iter().flat_map(|axis| axis.values.values());
            for next in all
                .filter(|other| other.provides.contains(last))
                .flat_map(|other| &other.needs)
            {
                waiting.push(path.iter().chain([next]).cloned().collect());
            }
        }
    }
    None
}

fn misuse<const N: usize>(message: String, path: [&str; N]) -> Misuse {
    Misuse {
        fault: Fault::new(Cause::Manifest, message),
        path: path.map(str::to_owned).to_vec(),
    }
}

impl Misuse {
    fn note(self, note: impl Into<String>) -> Self {
        Self {
            fault: self.fault.note(note),
            ..self
        }
    }
}

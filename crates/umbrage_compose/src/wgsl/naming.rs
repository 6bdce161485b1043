//! Names for the marks of a module.

use std::collections::{BTreeMap, BTreeSet, HashSet};

use naga::keywords::wgsl::RESERVED;

use super::{
    marks::{Length, Marked, Rank, Scope},
    text::{Piece, Text},
};

/// Marks and words used in a function, or outside of all functions.
#[derive(Default)]
struct Uses<'a> {
    marks: BTreeSet<usize>,
    words: HashSet<&'a str>,
}

/// A name for each mark in `text`.
///
/// Names at module scope all differ, from each other and from WGSL's own words that the text uses. Names within a
/// function differ from each other and from all names and words that the function uses; they may shadow names that
/// it does not use. Everything keeps its name where that is possible.
///
/// # Errors
/// A name that a host knows and that cannot be kept.
pub(super) fn choose(marked: &Marked, text: &Text<'_>) -> Result<Vec<String>, String> {
    let things = &marked.things;
    let mut uses: BTreeMap<Option<usize>, Uses<'_>> = BTreeMap::new();
    for line in &text.lines {
        let uses = uses.entry(line.function).or_default();
        uses.note(text, &line.pieces);
    }
    for pieces in text.told.values() {
        uses.entry(None).or_default().note(text, pieces);
    }
    let mut names = vec![String::new(); things.len()];
    let spoken: BTreeSet<_> = uses.values().flat_map(|uses| &uses.marks).collect();
    let mut global = Vec::new();
    for &mark in spoken {
        match things[mark].scope {
            Scope::Module(rank) => global.push((rank, mark)),
            Scope::Struct => names[mark] = things[mark].name.clone(),
            Scope::Function(_) | Scope::Unsaid => {}
        }
    }
    global.sort();
    let global: Vec<_> = global.into_iter().map(|(_, mark)| mark).collect();
    let mut taken = HashSet::new();
    for uses in uses.values() {
        taken.extend(uses.words.iter().map(|word| (*word).to_owned()));
    }
    give(marked, &global, taken, &mut names)?;
    for (function, uses) in &uses {
        let own = |mark: &&usize| matches!(things[**mark].scope, Scope::Function(_));
        if function.is_none() {
            continue;
        }
        let mut taken: HashSet<_> = uses.words.iter().map(|word| (*word).to_owned()).collect();
        let outside = uses.marks.iter().filter(|mark| !own(mark));
        let outside = outside.filter(|mark| things[**mark].scope != Scope::Struct);
        taken.extend(outside.map(|mark| names[*mark].clone()));
        let own: Vec<_> = uses.marks.iter().filter(own).copied().collect();
        give(marked, &own, taken, &mut names)?;
    }
    Ok(names)
}

impl<'a> Uses<'a> {
    fn note(&mut self, text: &Text<'a>, pieces: &[Piece<'a>]) {
        for piece in pieces {
            match piece {
                Piece::Mark(mark) | Piece::Length(Length::Override(mark)) => {
                    self.marks.insert(*mark);
                }
                Piece::Length(Length::Told(teller)) => {
                    let told = text.told.get(teller).map_or(&[][..], Vec::as_slice);
                    self.note(text, told);
                }
                Piece::Word(word) => {
                    self.words.insert(word);
                }
                Piece::Other(_) => {}
            }
        }
    }
}

/// Gives `marks` names that are not `taken`. The first mark with a name keeps it; each of the others gets its name
/// with a number added.
fn give(
    marked: &Marked,
    marks: &[usize],
    mut taken: HashSet<String>,
    names: &mut [String],
) -> Result<(), String> {
    let mut rest = Vec::new();
    for &mark in marks {
        let thing = &marked.things[mark];
        if !RESERVED.contains(&thing.name.as_str()) && taken.insert(thing.name.clone()) {
            names[mark] = thing.name.clone();
        } else if thing.scope == Scope::Module(Rank::Host) {
            return Err(thing.name.clone());
        } else {
            rest.push(mark);
        }
    }
    for mark in rest {
        let name = &marked.things[mark].name;
        let free = (1u32..)
            .map(|number| format!("{name}_{number}"))
            .find(|name| taken.insert(name.clone()));
        names[mark] = free.unwrap_or_default();
    }
    Ok(())
}

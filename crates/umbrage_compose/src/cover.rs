//! Covers: few permutations in which every pair of choices occurs that occurs in any.

use std::{
    collections::{BTreeMap, BTreeSet},
    sync::{
        PoisonError, RwLock,
        atomic::{AtomicUsize, Ordering},
    },
    thread,
};

use crate::{Composer, Error, ProjectedKey, Selection, Variant, bits::Bits};

/// One of so many permutations may be chosen, beside those that show a pair first. More make a smaller cover, and more
/// work.
const SAMPLE: u64 = 64;

/// Parts that the space is walked in.
const PARTS: usize = 256;

/// Permutations that may be chosen, each with its pairs.
type Candidates = BTreeMap<ProjectedKey, Bits>;

impl Composer {
    /// Keys of few permutations of `selection`, in which every pair of choices occurs that occurs in any of its
    /// permutations: values of two axes that both matter there. Sorted, and always the same.
    ///
    /// Faults show where few choices meet far more often than where many must, so a cover finds most of what drawing
    /// each permutation would (D. R. Kuhn, D. R. Wallace, A. M. Gallo, "Software Fault Interactions and Implications for
    /// Software Testing", 2004).
    ///
    /// # Errors
    /// The first fault that keeps a permutation's modules from being read.
    pub fn cover(&self, selection: &Selection) -> Result<Vec<ProjectedKey>, Error> {
        let candidates = self.candidates(selection)?;
        let mut missing = Bits::default();
        candidates.values().for_each(|pairs| missing.union(pairs));
        let mut by_gain: BTreeSet<_> = (candidates.iter())
            .map(|(key, pairs)| (std::cmp::Reverse(pairs.iter().count()), key))
            .collect();
        let mut chosen = Vec::new();
        // A candidate's gain only falls, so one that is still first after it was counted anew is the best.
        while let Some((promised, key)) = by_gain.pop_first() {
            let mut new = candidates[key].clone();
            new.intersect(&missing);
            let gain = std::cmp::Reverse(new.iter().count());
            if gain.0 == 0 {
                continue;
            }
            if gain != promised && by_gain.first().is_some_and(|next| *next < (gain, key)) {
                by_gain.insert((gain, key));
                continue;
            }
            missing.remove_all(&new);
            chosen.push(key.clone());
        }
        chosen.sort();
        Ok(chosen)
    }

    /// For each pair a permutation that has it, and a sample of all permutations.
    fn candidates(&self, selection: &Selection) -> Result<Candidates, Error> {
        let parts = self.select(selection).split(PARTS);
        let next = AtomicUsize::new(0);
        let candidates = RwLock::new(Ok(Candidates::new()));
        let walk = || {
            while let Some(part) = parts.get(next.fetch_add(1, Ordering::Relaxed)) {
                let mut seen = Bits::default();
                let mut own = Candidates::new();
                for variant in part.clone() {
                    if let Some(error) = variant.fault() {
                        let mut all = candidates.write().unwrap_or_else(PoisonError::into_inner);
                        // Of several faults that of the first key, whichever thread is first.
                        let known = all.as_ref().err();
                        if known.is_none_or(|known: &Error| error.to_string() < known.to_string()) {
                            *all = Err(error);
                        }
                        return;
                    }
                    let pairs = variant.pairs();
                    if !seen.has_all(&pairs) || variant.is_sampled() {
                        seen.union(&pairs);
                        own.insert(variant.key(), pairs);
                    }
                }
                let mut all = candidates.write().unwrap_or_else(PoisonError::into_inner);
                if let Ok(all) = all.as_mut() {
                    all.append(&mut own);
                }
            }
        };
        let threads = thread::available_parallelism().map_or(1, usize::from);
        thread::scope(|scope| {
            for _ in 0..threads {
                scope.spawn(walk);
            }
        });
        candidates
            .into_inner()
            .unwrap_or_else(PoisonError::into_inner)
    }
}

impl Variant<'_> {
    /// Pairs of its choices that both matter, as numbers.
    fn pairs(&self) -> Bits {
        let table = self.table();
        let mattering: Vec<_> = table.mattering_choices(&self.part, &self.chosen).collect();
        let mut pairs = Bits::default();
        for (index, a) in mattering.iter().enumerate() {
            for b in &mattering[..index] {
                // Pairs of numbers in a triangle: a > b.
                pairs.insert(a * (a - 1) / 2 + b);
            }
        }
        pairs
    }

    /// Whether it is one of the sample, which is the same on every machine.
    fn is_sampled(&self) -> bool {
        let numbers = self.chosen.iter();
        let hash = numbers.fold(0u64, |hash, value| {
            (hash ^ *value as u64)
                .wrapping_mul(0x9E37_79B9_7F4A_7C15)
                .rotate_left(29)
        });
        hash % SAMPLE == 0
    }
}

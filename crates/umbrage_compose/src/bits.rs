//! Sets of small numbers.

/// A set of small numbers: features, capabilities, values. Numbers below 256 need no memory but its own.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(crate) struct Bits {
    first: [u64; FIRST],
    /// The words after the first ones. The last is not 0, so that equal sets are equal values.
    rest: Vec<u64>,
}

const FIRST: usize = 4;

impl Bits {
    pub(crate) fn insert(&mut self, number: usize) {
        let word = number / 64;
        let words = match word.checked_sub(FIRST) {
            None => &mut self.first[word],
            Some(word) => {
                if self.rest.len() <= word {
                    self.rest.resize(word + 1, 0);
                }
                &mut self.rest[word]
            }
        };
        *words |= 1 << (number % 64);
    }

    pub(crate) fn contains(&self, number: usize) -> bool {
        let word = number / 64;
        let word = match word.checked_sub(FIRST) {
            None => self.first[word],
            Some(word) => self.rest.get(word).copied().unwrap_or(0),
        };
        word >> (number % 64) & 1 == 1
    }

    /// The members, ascending.
    pub(crate) fn iter(&self) -> impl Iterator<Item = usize> {
        let words = self.first.iter().chain(&self.rest);
        words.enumerate().flat_map(|(index, &word)| {
            let next = |rest: &u64| Some(rest & (rest - 1)).filter(|rest| *rest != 0);
            let first = Some(word).filter(|word| *word != 0);
            let rests = std::iter::successors(first, next);
            rests.map(move |rest| index * 64 + rest.trailing_zeros() as usize)
        })
    }

    /// Whether all members of `other` are members of this set.
    pub(crate) fn has_all(&self, other: &Self) -> bool {
        self.rest.len() >= other.rest.len() && self.pairs(other).all(|(word, of)| of & !word == 0)
    }

    /// Whether this set and `other` share a member.
    pub(crate) fn meets(&self, other: &Self) -> bool {
        self.pairs(other).any(|(word, of)| word & of != 0)
    }

    pub(crate) fn union(&mut self, other: &Self) {
        self.change(other, |word, of| word | of);
    }

    pub(crate) fn intersect(&mut self, other: &Self) {
        self.change(other, |word, of| word & of);
    }

    pub(crate) fn remove_all(&mut self, other: &Self) {
        self.change(other, |word, of| word & !of);
    }

    /// Words that both sets have.
    fn pairs(&self, other: &Self) -> impl Iterator<Item = (u64, u64)> {
        let first = self.first.into_iter().zip(other.first);
        let rest = self.rest.iter().zip(&other.rest);
        first.chain(rest.map(|(word, of)| (*word, *of)))
    }

    fn change(&mut self, other: &Self, new: impl Fn(u64, u64) -> u64) {
        for (word, of) in self.first.iter_mut().zip(other.first) {
            *word = new(*word, of);
        }
        if self.rest.is_empty() && other.rest.is_empty() {
            return;
        }
        let words = self.rest.len().max(other.rest.len());
        self.rest.resize(words, 0);
        let others = other.rest.iter().copied().chain(std::iter::repeat(0));
        for (word, of) in self.rest.iter_mut().zip(others) {
            *word = new(*word, of);
        }
        while self.rest.last() == Some(&0) {
            self.rest.pop();
        }
    }
}

impl FromIterator<usize> for Bits {
    fn from_iter<I: IntoIterator<Item = usize>>(numbers: I) -> Self {
        let mut bits = Self::default();
        numbers.into_iter().for_each(|number| bits.insert(number));
        bits
    }
}

impl Extend<usize> for Bits {
    fn extend<I: IntoIterator<Item = usize>>(&mut self, numbers: I) {
        numbers.into_iter().for_each(|number| self.insert(number));
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use proptest::prelude::*;

    use super::*;

    fn numbers() -> impl Strategy<Value = BTreeSet<usize>> {
        prop::collection::btree_set(0..400usize, 0..12)
    }

    proptest! {
        #[test]
        fn sets_of_bits_are_sets(a in numbers(), b in numbers()) {
            let bits = |set: &BTreeSet<usize>| set.iter().copied().collect::<Bits>();
            let (left, right) = (bits(&a), bits(&b));
            prop_assert_eq!(left.iter().collect::<BTreeSet<_>>(), a.clone());
            let mut union = left.clone();
            union.union(&right);
            prop_assert_eq!(union, bits(&(&a | &b)));
            let mut both = left.clone();
            both.intersect(&right);
            prop_assert_eq!(both, bits(&(&a & &b)));
            let mut rest = left.clone();
            rest.remove_all(&right);
            prop_assert_eq!(rest, bits(&(&a - &b)));
            prop_assert_eq!(left.has_all(&right), a.is_superset(&b));
            prop_assert_eq!(left.meets(&right), !a.is_disjoint(&b));
            prop_assert!((0..400).all(|number| left.contains(number) == a.contains(&number)));
        }
    }
}

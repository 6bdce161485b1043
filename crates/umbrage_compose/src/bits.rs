//! Sets of small numbers.

use smallvec::SmallVec;

/// A set of small numbers: features, capabilities, values. A set of numbers below 256 needs no memory of its own.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(crate) struct Bits(
    /// The last word is not 0, so that equal sets are equal values.
    SmallVec<[u64; 4]>,
);

impl Bits {
    pub(crate) fn insert(&mut self, number: usize) {
        let word = number / 64;
        if self.0.len() <= word {
            self.0.resize(word + 1, 0);
        }
        self.0[word] |= 1 << (number % 64);
    }

    pub(crate) fn contains(&self, number: usize) -> bool {
        self.word(number / 64) >> (number % 64) & 1 == 1
    }

    /// The members, ascending.
    pub(crate) fn iter(&self) -> impl Iterator<Item = usize> {
        self.0.iter().enumerate().flat_map(|(index, &word)| {
            let next = |rest: &u64| Some(rest & (rest - 1)).filter(|rest| *rest != 0);
            let first = Some(word).filter(|word| *word != 0);
            let rests = std::iter::successors(first, next);
            rests.map(move |rest| index * 64 + rest.trailing_zeros() as usize)
        })
    }

    /// Whether all members of `other` are members of this set.
    pub(crate) fn has_all(&self, other: &Self) -> bool {
        let mut words = other.0.iter().enumerate();
        words.all(|(i, word)| word & !self.word(i) == 0)
    }

    /// Whether this set and `other` share a member.
    pub(crate) fn meets(&self, other: &Self) -> bool {
        let mut words = self.0.iter().zip(&other.0);
        words.any(|(word, other)| word & other != 0)
    }

    pub(crate) fn union(&mut self, other: &Self) {
        if self.0.len() < other.0.len() {
            self.0.resize(other.0.len(), 0);
        }
        for (word, other) in self.0.iter_mut().zip(&other.0) {
            *word |= other;
        }
    }

    pub(crate) fn intersect(&mut self, other: &Self) {
        self.0.truncate(other.0.len());
        for (word, other) in self.0.iter_mut().zip(&other.0) {
            *word &= other;
        }
        self.trim();
    }

    pub(crate) fn remove_all(&mut self, other: &Self) {
        for (word, other) in self.0.iter_mut().zip(&other.0) {
            *word &= !other;
        }
        self.trim();
    }

    fn trim(&mut self) {
        while self.0.last() == Some(&0) {
            self.0.pop();
        }
    }

    fn word(&self, index: usize) -> u64 {
        self.0.get(index).copied().unwrap_or(0)
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

//! Things that are kept from frame to frame, as long as there are not too many.

use std::{borrow::Borrow, collections::HashMap, hash::Hash};

/// Things by what they were made for. Where there are more than `most`, those go that were not asked for the longest; what
/// the last frame asked for stays, however much that is.
pub(crate) struct Kept<K, V> {
    most: usize,
    frame: u64,
    /// Each with the frame that asked for it last.
    things: HashMap<K, (V, u64)>,
    let_go: u64,
}

impl<K: Eq + Hash, V> Kept<K, V> {
    pub(crate) fn new(most: usize) -> Self {
        Self {
            most,
            frame: 0,
            things: HashMap::new(),
            let_go: 0,
        }
    }

    pub(crate) fn get<Q: Eq + Hash + ?Sized>(&mut self, key: &Q) -> Option<&mut V>
    where
        K: Borrow<Q>,
    {
        let (thing, asked) = self.things.get_mut(key)?;
        *asked = self.frame;
        Some(thing)
    }

    pub(crate) fn insert(&mut self, key: K, thing: V) {
        self.things.insert(key, (thing, self.frame));
    }

    pub(crate) fn remove(&mut self, key: &K) {
        self.things.remove(key);
    }

    /// Begins a frame; lets go of what is too much.
    pub(crate) fn begin_frame(&mut self) {
        let ended = self.frame;
        self.frame += 1;
        let Some(over @ 1..) = self.things.len().checked_sub(self.most) else {
            return;
        };
        let mut asked: Vec<_> = self.things.values().map(|(_, asked)| *asked).collect();
        asked.sort_unstable();
        let last_to_go = asked[over - 1];
        let before = self.things.len();
        self.things
            .retain(|_, (_, asked)| *asked > last_to_go || *asked == ended);
        self.let_go += (before - self.things.len()) as u64;
    }

    /// How many were too much so far.
    pub(crate) fn let_go(&self) -> u64 {
        self.let_go
    }

    pub(crate) fn values(&self) -> impl Iterator<Item = &V> {
        self.things.values().map(|(thing, _)| thing)
    }

    pub(crate) fn clear(&mut self) {
        self.things.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_not_asked_for_the_longest_goes_first() {
        let mut kept = Kept::new(3);
        for number in 0..5 {
            kept.insert(number, ());
            kept.begin_frame();
        }
        assert_eq!(kept.let_go(), 2);
        let there: Vec<_> = (0..5).filter(|number| kept.get(number).is_some()).collect();
        assert_eq!(there, [2, 3, 4]);
        // All of a frame stays, though it is too much.
        for number in 10..20 {
            kept.insert(number, ());
        }
        kept.begin_frame();
        assert!((10..20).all(|number| kept.get(&number).is_some()));
        assert_eq!(kept.values().count(), 13);
        kept.begin_frame();
        kept.begin_frame();
        assert_eq!(kept.values().count(), 0, "nothing asked for them since");
    }
}

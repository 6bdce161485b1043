//! Threads that make things: what is wanted most first, and never more waiting than there is room for.

use std::{
    cmp::Reverse,
    collections::{HashMap, HashSet},
    hash::Hash,
    sync::{
        Arc, Condvar, Mutex, MutexGuard, PoisonError,
        mpsc::{self, Receiver, Sender},
    },
    thread::{self, JoinHandle},
};

/// Makes things on threads of its own, which begin with the first one that is asked for.
pub(crate) struct Workers<K, V> {
    make: Arc<dyn Fn(&K) -> V + Send + Sync>,
    board: Arc<Board<K>>,
    made: Receiver<(K, V)>,
    send: Sender<(K, V)>,
    threads: Vec<JoinHandle<()>>,
    asked: u64,
    most: usize,
}

/// How much a thing is wanted: the later the frame that asked for it, the more of it is seen and the earlier it came, the more.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Rank {
    frame: u64,
    seen: u32,
    came: Reverse<u64>,
}

struct Board<K> {
    state: Mutex<State<K>>,
    bell: Condvar,
}

struct State<K> {
    waiting: HashMap<K, Rank>,
    /// Those that a thread has begun, until they are collected.
    begun: HashSet<K>,
    closed: bool,
}

impl<K> Board<K> {
    /// A thread that panicked leaves nothing half done here.
    fn lock(&self) -> MutexGuard<'_, State<K>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<K: Clone + Eq + Hash + Send + Sync + 'static, V: Send + 'static> Workers<K, V> {
    /// Workers that make things by `make`, which does not panic; at most so many things wait for them, or to be
    /// collected.
    pub(crate) fn new(most: usize, make: impl Fn(&K) -> V + Send + Sync + 'static) -> Self {
        let (send, made) = mpsc::channel();
        Self {
            make: Arc::new(make),
            board: Arc::new(Board {
                state: Mutex::new(State {
                    waiting: HashMap::new(),
                    begun: HashSet::new(),
                    closed: false,
                }),
                bell: Condvar::new(),
            }),
            made,
            send,
            threads: Vec::new(),
            asked: 0,
            most,
        }
    }

    /// Asks for a thing, of which so much is seen in this frame; asked for again, it moves up. Returns what was dropped as there
    /// was no room: it is to be asked for again.
    pub(crate) fn ask(&mut self, key: &K, (frame, seen): (u64, u32)) -> Option<K> {
        self.asked += 1;
        let came = Reverse(self.asked);
        let mut state = self.board.lock();
        if state.begun.contains(key) {
            return None;
        }
        if let Some(rank) = state.waiting.get_mut(key) {
            // Of two that ask in one frame, the one that sees more counts.
            (rank.frame, rank.seen) = (rank.frame, rank.seen).max((frame, seen));
            return None;
        }
        state
            .waiting
            .insert(key.clone(), Rank { frame, seen, came });
        // Things made and not collected take room as well, but for what threads have in hand.
        let room = self.most + self.threads.len();
        let least = (state.waiting.len() + state.begun.len() > room)
            .then(|| state.waiting.iter().min_by_key(|(_, rank)| **rank))
            .flatten()
            .map(|(key, _)| key.clone());
        if let Some(least) = &least {
            state.waiting.remove(least);
        }
        drop(state);
        self.board.bell.notify_one();
        self.begin();
        least
    }

    /// Starts the threads. Half of the cores are left to the frames; where no thread can be had, the work is done here.
    fn begin(&mut self) {
        if !self.threads.is_empty() {
            return;
        }
        let cores = thread::available_parallelism().map_or(1, usize::from);
        for _ in 0..(cores / 2).max(1) {
            let (make, board, send) = (
                Arc::clone(&self.make),
                Arc::clone(&self.board),
                self.send.clone(),
            );
            let thread = thread::Builder::new().name("umbrage".to_owned());
            self.threads
                .extend(thread.spawn(move || work(&*make, &board, &send)));
        }
        if self.threads.is_empty() {
            while let Some(key) = take(&mut self.board.lock()) {
                let made = (self.make)(&key);
                // The receiver is ours.
                let _ = self.send.send((key, made));
            }
        }
    }

    /// Things that were made since the last time.
    pub(crate) fn collect(&mut self) -> Vec<(K, V)> {
        let made: Vec<_> = self.made.try_iter().collect();
        if !made.is_empty() {
            let mut state = self.board.lock();
            for (key, _) in &made {
                state.begun.remove(key);
            }
        }
        made
    }

    /// How many things were asked for and not collected.
    pub(crate) fn waiting(&self) -> usize {
        let state = self.board.lock();
        state.waiting.len() + state.begun.len()
    }

    /// Drops all that no thread has begun.
    pub(crate) fn forget(&mut self) {
        self.board.lock().waiting.clear();
    }
}

/// The thing that is wanted most, begun.
fn take<K: Clone + Eq + Hash>(state: &mut State<K>) -> Option<K> {
    let (key, _) = state.waiting.iter().max_by_key(|(_, rank)| **rank)?;
    let key = key.clone();
    state.waiting.remove(&key);
    state.begun.insert(key.clone());
    Some(key)
}

/// A thread's life.
fn work<K: Clone + Eq + Hash, V>(
    make: &(dyn Fn(&K) -> V + Send + Sync),
    board: &Board<K>,
    send: &Sender<(K, V)>,
) {
    loop {
        let mut state = board.lock();
        let key = loop {
            if state.closed {
                return;
            }
            match take(&mut state) {
                Some(key) => break key,
                None => {
                    let rung = board.bell.wait(state);
                    state = rung.unwrap_or_else(PoisonError::into_inner);
                }
            }
        };
        drop(state);
        let made = make(&key);
        if send.send((key, made)).is_err() {
            return;
        }
    }
}

impl<K, V> Drop for Workers<K, V> {
    /// Waits for what is being made, and no more: a thread must not outlive the driver that it calls.
    fn drop(&mut self) {
        self.board.lock().closed = true;
        self.board.bell.notify_all();
        for thread in self.threads.drain(..) {
            // It does not panic, and what it made is wanted no more.
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use std::{
        sync::mpsc::sync_channel,
        time::{Duration, Instant},
    };

    use super::*;

    fn all<V: Send + 'static>(workers: &mut Workers<u32, V>) -> Vec<(u32, V)> {
        let start = Instant::now();
        let mut made = Vec::new();
        while workers.waiting() > 0 {
            assert!(start.elapsed() < Duration::from_secs(60), "it hangs");
            made.extend(workers.collect());
            thread::yield_now();
        }
        made.extend(workers.collect());
        made
    }

    /// Workers whose threads wait for a word before each thing: nothing is made before all is asked for.
    fn held(most: usize) -> (Workers<u32, ()>, mpsc::SyncSender<()>) {
        let (go, gate) = sync_channel::<()>(1_000);
        let gate = Mutex::new(gate);
        let workers = Workers::new(most, move |_| {
            let _ = gate.lock().unwrap_or_else(PoisonError::into_inner).recv();
        });
        (workers, go)
    }

    #[test]
    fn what_is_seen_more_and_later_is_made_first() {
        // In the order in which they are taken: the rank alone decides.
        let mut state = State {
            waiting: HashMap::new(),
            begun: HashSet::new(),
            closed: false,
        };
        let wishes = [(1, 9), (2, 1), (2, 7), (2, 7), (0, 99)];
        for (key, (frame, seen)) in (0..).zip(wishes) {
            let came = Reverse(u64::from(key));
            state.waiting.insert(key, Rank { frame, seen, came });
        }
        let taken: Vec<u32> = std::iter::from_fn(|| take(&mut state)).collect();
        assert_eq!(taken, [2, 3, 1, 0, 4]);
    }

    #[test]
    fn each_is_made_once_however_often_it_is_asked_for() {
        let mut workers = Workers::new(100, |key: &u32| key * 2);
        for frame in 0..3 {
            for key in 0..20 {
                assert_eq!(workers.ask(&key, (frame, 1)), None);
            }
        }
        let mut made = all(&mut workers);
        made.sort_unstable();
        made.dedup();
        assert_eq!(made, (0..20).map(|key| (key, key * 2)).collect::<Vec<_>>());
    }

    #[test]
    fn where_there_is_no_room_the_least_seen_is_dropped() {
        let (mut workers, go) = held(4);
        let threads = (thread::available_parallelism().map_or(1, usize::from) / 2).max(1) as u32;
        // They are taken at once, and held.
        for key in 0..threads {
            workers.ask(&key, (9, 9));
        }
        while !workers.board.lock().waiting.is_empty() {
            thread::yield_now();
        }
        let mut dropped = Vec::new();
        for key in 100..108 {
            dropped.extend(workers.ask(&key, (1, key)));
        }
        assert_eq!(dropped, [100, 101, 102, 103]);
        // One that is seen less than all others is not taken in.
        assert_eq!(workers.ask(&200, (1, 0)), Some(200));
        drop(go);
        assert_eq!(all(&mut workers).len(), threads as usize + 4);
    }

    #[test]
    fn to_let_go_of_workers_waits_for_what_is_in_hand_alone() {
        let mut workers = Workers::new(1_000, |_: &u32| thread::sleep(Duration::from_millis(20)));
        for key in 0..1_000 {
            workers.ask(&key, (0, 0));
        }
        let start = Instant::now();
        drop(workers);
        // All of it would take 20 s of every thread.
        assert!(start.elapsed() < Duration::from_secs(5));
    }
}

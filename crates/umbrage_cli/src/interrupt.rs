//! Ctrl-C, and the other ways to be asked to end.
//!
//! The command ends at once, unless it is just writing a folder. That is short work; it is given up at the
//! next file, and what was begun is removed before the process ends.

use std::{
    process,
    sync::{
        Mutex, MutexGuard, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
};

use anyhow::{Context, Result, bail};

/// Status that a shell gives a command that Ctrl-C ended.
pub(crate) const STATUS: u8 = 130;

/// Held while there are files that must not be left behind.
static WRITING: Mutex<()> = Mutex::new(());

static ASKED: AtomicBool = AtomicBool::new(false);

/// From here on Ctrl-C waits for [`writing`].
pub(crate) fn install() -> Result<()> {
    ctrlc::set_handler(|| {
        ASKED.store(true, Ordering::SeqCst);
        let _none_is_writing = lock();
        process::exit(STATUS.into());
    })
    .context("interrupts cannot be waited for")
}

/// Keeps the process until the guard is dropped.
pub(crate) fn writing() -> MutexGuard<'static, ()> {
    lock()
}

/// An error once the process was asked to end.
pub(crate) fn check() -> Result<()> {
    if asked() {
        bail!("interrupted; nothing was written");
    }
    Ok(())
}

pub(crate) fn asked() -> bool {
    ASKED.load(Ordering::SeqCst)
}

/// A thread that panicked has removed its files on the way: the lock guards nothing else.
fn lock() -> MutexGuard<'static, ()> {
    WRITING.lock().unwrap_or_else(PoisonError::into_inner)
}

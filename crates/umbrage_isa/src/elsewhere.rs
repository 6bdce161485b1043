//! In place of the two processes where there is no RADV.

use std::{ffi::OsStr, io, process::ExitStatus, time::Duration};

use crate::{
    CompilerOptions, IsaError,
    wire::{Executable, Job},
};

pub(crate) enum Child {}

#[allow(dead_code, reason = "what never runs is never silent either")]
pub(crate) enum Silence {
    Ended(ExitStatus, String),
    TimedOut,
}

impl Child {
    pub(crate) fn start(_: &CompilerOptions, _: &OsStr) -> Result<Self, IsaError> {
        Err(IsaError::Platform)
    }

    pub(crate) fn no_family(_: &CompilerOptions, _: &OsStr, _: String) -> IsaError {
        IsaError::Platform
    }

    pub(crate) fn compile(
        &mut self,
        _: &Job,
        _: Duration,
    ) -> Result<Result<Vec<Executable>, String>, Silence> {
        match *self {}
    }
}

pub(crate) fn serve(_: &dyn Fn(&Job)) -> io::Result<()> {
    Err(io::Error::other(IsaError::Platform))
}

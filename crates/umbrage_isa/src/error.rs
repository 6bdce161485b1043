//! Errors.

use std::{io, path::PathBuf, process::ExitStatus, time::Duration};

use umbrage_compose::ProjectedKey;

/// Why there are no figures.
#[derive(Debug, thiserror::Error)]
pub enum IsaError {
    /// The driver is not there.
    #[error(
        "Mesa's driver for AMD GPUs, RADV, is not installed: there is no radeon_icd manifest in {}; install it \
         and the Vulkan loader (Debian: apt-get install mesa-vulkan-drivers libvulkan1)",
        listed(.looked)
    )]
    NoDriver {
        /// The folders that were looked through.
        looked: Vec<PathBuf>,
    },
    /// The driver opens no device for any family.
    #[error(
        "RADV opens no device for `{family}`, nor for any other family; it needs the null device of Mesa, \
         which 22.3 (Debian 12) has and 26.2 has no more. It said: {said}"
    )]
    NoDevice {
        /// The family asked for.
        family: String,
        /// The driver's words.
        said: String,
    },
    /// The driver has no such family.
    #[error(
        "this machine's RADV has no GPU family `{family}`; it has {}",
        .known.join(", ")
    )]
    Family {
        /// The family asked for.
        family: String,
        /// Families that there are.
        known: Vec<String>,
    },
    /// The driver opened something else.
    #[error(
        "`{family}` was asked for, but the driver opened `{device}`, whose figures would be another GPU's; \
         name the family as Mesa does"
    )]
    OtherDevice {
        /// The family asked for.
        family: String,
        /// The device's own name.
        device: String,
    },
    /// The program that is to compile could not be started.
    #[error("`{}` cannot be started to compile: {source}", .program.display())]
    Start {
        /// The program.
        program: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The program that was started to compile does something else.
    #[error(
        "`{}` was started to compile, but does not answer; its main calls umbrage_isa::serve_if_asked() \
         before all else. It said: {said}",
        .program.display()
    )]
    NotServing {
        /// The program.
        program: PathBuf,
        /// Its words.
        said: String,
    },
    /// The driver ended its process.
    #[error("the driver crashed ({status}) at the permutation {key}; it said: {said}")]
    Crashed {
        /// The permutation's key.
        key: ProjectedKey,
        /// How it ended.
        status: ExitStatus,
        /// Its words.
        said: String,
    },
    /// The driver does not come to an end.
    #[error("the driver took longer than {} s for the permutation {key} and was ended", .limit.as_secs_f64())]
    TimedOut {
        /// The permutation's key.
        key: ProjectedKey,
        /// How long it was waited for.
        limit: Duration,
    },
    /// The permutation or its pipeline cannot be compiled.
    #[error("the permutation {key} cannot be compiled: {reason}")]
    Refused {
        /// The permutation's key.
        key: ProjectedKey,
        /// Why.
        reason: String,
    },
    /// The driver leaves a figure out.
    #[error(
        "the driver does not say `{statistic}` of `{entry_point}` in the permutation {key}; another version of \
         Mesa may (22.3 does)"
    )]
    Statistic {
        /// The permutation's key.
        key: ProjectedKey,
        /// The stage's entry point.
        entry_point: String,
        /// The missing statistic.
        statistic: &'static str,
    },
    /// The system has neither RADV nor the means to talk to it.
    #[error("RADV runs on Linux and its like, and not on this system")]
    Platform,
}

fn listed(folders: &[PathBuf]) -> String {
    let folders: Vec<_> = folders.iter().map(|f| f.display().to_string()).collect();
    folders.join(", ")
}

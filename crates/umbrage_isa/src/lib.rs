//! What a GPU's compiler makes of a permutation, without a GPU.

mod budget;
#[cfg(unix)]
mod child;
mod compiler;
mod cost;
mod driver;
mod error;
mod job;
#[cfg(unix)]
mod server;
mod state;
mod vulkan;
mod wire;
mod words;

pub use budget::{Budget, Excess};
pub use compiler::{Compiler, CompilerOptions, costs};
pub use cost::{Isa, Room, StageCost};
pub use error::IsaError;
pub use state::{ColorTarget, DepthTarget, PipelineState};

/// Set for a process that is to compile.
const SERVE: &str = "UMBRAGE_ISA_SERVE";

/// Turns the process into a compiler where it was started to be one, and then does not return; otherwise does
/// nothing. The first call in the main of a program that uses a [`Compiler`].
pub fn serve_if_asked() {
    testing::serve_if_asked(&|_| ());
}

#[doc(hidden)]
pub mod testing {
    //! For this project's tests alone.

    /// As [`serve_if_asked`](crate::serve_if_asked), calling `before` with the entry points' names before each
    /// pipeline, so that a test may crash.
    pub fn serve_if_asked(before: &dyn Fn(&[&str])) {
        if std::env::var_os(crate::SERVE).is_none() {
            return;
        }
        let served = crate::server::serve(&|job| before(&job.entry_points()));
        std::process::exit(match served {
            Ok(()) => 0,
            Err(error) => {
                eprintln!("{error}");
                1
            }
        });
    }
}

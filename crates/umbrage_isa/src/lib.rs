//! Figures of a GPU's compiler for a permutation, without a GPU.
//!
//! # The model
//! Mesa's Vulkan driver for AMD's GPUs, RADV, compiles for a GPU that is not there: told a family by
//! `RADV_FORCE_FAMILY`, it opens a *null device* of that family, and a pipeline made on it has been through the
//! same compiler, ACO, as on the hardware. `VK_KHR_pipeline_executable_properties` then tells what became of
//! each stage. The figures are counts and estimates of the compiler's, not measurements: the same input gives
//! the same figures, on any machine with the same Mesa.
//!
//! A [`Compiler`] takes linked permutations and how they are drawn ([`PipelineState`]), and gives a
//! [`StageCost`] for each stage. The pipeline is the one that wgpu would make: vertex attributes and bindings
//! from the permutation's reflection, SPIR-V from naga with the options of wgpu's Vulkan backend, one sample a
//! pixel, reads kept within bounds by the device. [`costs`] shares a list of permutations among all cores, and a
//! [`Budget`] holds them against limits.
//!
//! ```standalone_crate
//! use umbrage_compose::{Composer, Library, Target};
//! use umbrage_isa::{Compiler, IsaError, PipelineState};
//!
//! fn main() -> Result<(), Box<dyn std::error::Error>> {
//!     // The process that compiles is this program, started again: it goes no further than here.
//!     umbrage_isa::serve_if_asked();
//!
//!     let library = Library::new([umbrage_shader_lib::package()?])?;
//!     let key = library.key([("pass", "shadow_term"), ("method", "basic")])?;
//!     let permutation = Composer::new(library, Target::webgpu()).compose(&key)?.permutation;
//!
//!     let mut compiler = Compiler::start("navi21")?;
//!     for cost in compiler.cost(&permutation, &PipelineState::of(&permutation))? {
//!         println!("{}: {} instructions", cost.entry_point, cost.isa.instructions);
//!         assert!(cost.isa.instructions > 100 && cost.room.spilled_vgprs == 0);
//!     }
//!     Ok(())
//! }
//! ```
//!
//! # What the figures mean
//! - **Instructions** and **code size** are those of the machine code: each instruction once, however often it
//!   runs or whether it is jumped over. A loop that the compiler unrolls has more of them and is no slower.
//! - **Latency** is how many cycles a lone wave takes, waiting for memory included. **Inverse throughput** is how
//!   many cycles the busiest unit is busy with a wave: of two shaders in a full GPU the one with less is
//!   quicker. It is the figure to compare methods by.
//! - Both are estimates without data: a fetch takes a fixed time, whatever the caches do, what stands in a branch
//!   counts for a part, and the body of a loop that is still there for a guess, eight times in Mesa 22.3, whatever
//!   its real number. So compare shaders whose loops are all unrolled, or alike: the basic method's filter under a
//!   point light has the same figures for eleven texels as for fifteen.
//! - **VGPRs** and **SGPRs** are set aside for a wave in grains of the hardware's (all scalar registers, on RDNA);
//!   the more of them, the fewer **waves** fit on a SIMD at a time to hide latency. **Spilled** registers did not
//!   fit at all; **scratch** is where vector registers go then.
//! - The **vertex stage** holds what the driver adds to it: on RDNA, code that leaves out triangles that no one
//!   sees, and the **LDS** that it does so with.
//!
//! Costs outside the shader are in none of it: the fetches' bandwidth, overdraw, the depth test, the blending.
//! Figures of two versions of Mesa may differ by some percent; of two families, by all means.
//!
//! # Two processes
//! The family and the driver are environment variables, read when the Vulkan loader starts, and drivers may
//! crash over what they are fed. So a compiler is a process of its own: the same program again, which
//! [`serve_if_asked`] turns into the server. It sees neither variables that would change the figures nor Mesa's
//! shader cache, of which it leaves none behind. A driver that crashes or hangs is an error that names the
//! permutation, and the next one is compiled by a new process. The device's name is held against the family
//! that was asked for: a wrong name is an error that lists the right ones, never another GPU's figures.
//!
//! # Unsafe code
//! The workspace forbids it. This crate alone denies it and allows it in one private module, since wgpu cannot
//! open a device without hardware and Vulkan has no other interface than unsafe functions. That module runs in
//! the server process only.

mod budget;
#[cfg(unix)]
mod child;
#[cfg(not(unix))]
#[path = "elsewhere.rs"]
mod child;
mod compiler;
mod cost;
#[cfg_attr(not(unix), allow(dead_code, reason = "there is no driver"))]
mod driver;
mod error;
mod job;
#[cfg(unix)]
mod server;
#[cfg(not(unix))]
use child as server;
mod state;
#[cfg(unix)]
mod vulkan;
#[cfg_attr(not(unix), allow(dead_code, reason = "there is no one to talk to"))]
mod wire;
mod words;

pub use budget::{Budget, Excess};
pub use compiler::{Compiler, CompilerOptions, costs};
pub use cost::{Isa, Room, StageCost};
pub use error::IsaError;
pub use state::{ColorTarget, DepthTarget, PipelineState};

/// Set for a process that is to compile.
const SERVE: &str = "UMBRAGE_ISA_SERVE";

/// Turns the process into a compiler where a [`Compiler`] started it to be one, and then does not return;
/// otherwise does nothing. The first call in the main of a program that uses one.
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

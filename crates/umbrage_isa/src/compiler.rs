//! Asks a process of its own for what permutations cost.

use std::{
    env,
    ffi::OsString,
    path::PathBuf,
    sync::atomic::{AtomicUsize, Ordering},
    thread,
    time::Duration,
};

use umbrage_compose::Permutation;

use crate::{
    IsaError, PipelineState, SERVE, StageCost,
    child::{Child, Silence},
    driver,
    job::{Planned, plan},
    wire::Executable,
    words,
};

/// Target of the compiler, and the program that compiles.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CompilerOptions {
    /// The GPU family, by Mesa's name.
    pub family: String,
    /// The program that compiles: one whose main calls [`serve_if_asked`](crate::serve_if_asked) first.
    pub program: PathBuf,
    /// Its arguments.
    pub args: Vec<OsString>,
    /// Folders to look for the driver's manifest in.
    pub folders: Vec<PathBuf>,
    /// How long one pipeline may take.
    pub limit: Duration,
}

impl CompilerOptions {
    /// The family that is compiled for where none is named: AMD's RDNA 2 of 2020, which desktops and
    /// consoles have.
    pub const FAMILY: &str = "navi21";

    /// Compiles for `family` by this very program, with the driver where the Vulkan loader finds it, a
    /// minute for a pipeline at the most.
    pub fn new(family: &str) -> Self {
        Self {
            family: family.to_ascii_lowercase(),
            // Where it cannot be told, starting it says so.
            program: env::current_exe().unwrap_or_default(),
            args: Vec::new(),
            folders: driver::folders(),
            limit: Duration::from_secs(60),
        }
    }
}

impl Default for CompilerOptions {
    fn default() -> Self {
        Self::new(Self::FAMILY)
    }
}

/// A compiler for one GPU family, in a process of its own.
pub struct Compiler {
    options: CompilerOptions,
    manifests: OsString,
    /// None after a crash, until it is needed again.
    child: Option<Child>,
}

impl Compiler {
    /// Starts a compiler for `family`, such as `navi21`; this program must call
    /// [`serve_if_asked`](crate::serve_if_asked) first in its main.
    ///
    /// # Errors
    /// Where the driver is missing, has no such family, or this program does not serve.
    pub fn start(family: &str) -> Result<Self, IsaError> {
        Self::with(&CompilerOptions::new(family))
    }

    /// Starts a compiler.
    ///
    /// # Errors
    /// Where the driver is missing, has no such family, or the program does not serve.
    pub fn with(options: &CompilerOptions) -> Result<Self, IsaError> {
        if env::var_os(SERVE).is_some() {
            // Without this a program that does not serve would start itself for ever.
            return Err(IsaError::NotServing {
                program: options.program.clone(),
                said: "it was about to start itself again".to_owned(),
            });
        }
        let manifests = driver::manifests(&options.folders)?;
        if !driver::may_be_family(&options.family) {
            return Err(Child::no_family(options, &manifests, String::new()));
        }
        let child = Some(Child::start(options, &manifests)?);
        Ok(Self {
            options: options.clone(),
            manifests,
            child,
        })
    }

    /// The GPU family that is compiled for.
    pub fn family(&self) -> &str {
        &self.options.family
    }

    /// Cost of each stage of `permutation` where it is drawn as `state` says, in the order of a
    /// pipeline's stages. Of several vertex or fragment entry points the first is taken, as by the renderer.
    ///
    /// # Errors
    /// A permutation that cannot be compiled, and a driver that crashes, hangs or leaves a figure out. The next permutation
    /// is compiled all the same, by a new process.
    pub fn cost(
        &mut self,
        permutation: &Permutation,
        state: &PipelineState,
    ) -> Result<Vec<StageCost>, IsaError> {
        let key = || permutation.key.clone();
        let refused = |reason| IsaError::Refused { key: key(), reason };
        let mut costs = Vec::new();
        for planned in plan(permutation, state).map_err(refused)? {
            let mut child = match self.child.take() {
                Some(child) => child,
                None => Child::start(&self.options, &self.manifests)?,
            };
            let answer = child.compile(&planned.job, self.options.limit);
            let executables = answer.map_err(|silence| match silence {
                Silence::TimedOut => IsaError::TimedOut {
                    key: key(),
                    limit: self.options.limit,
                },
                Silence::Ended(status, said) => IsaError::Crashed {
                    key: key(),
                    status,
                    said,
                },
            })?;
            self.child = Some(child);
            let executables = executables.map_err(refused)?;
            costs.extend(self.stages(permutation, &planned, &executables)?);
        }
        Ok(costs)
    }

    fn stages(
        &self,
        permutation: &Permutation,
        planned: &Planned,
        executables: &[Executable],
    ) -> Result<Vec<StageCost>, IsaError> {
        let costs = planned.entry_points.iter().map(|(stage, entry_point)| {
            let flag = words::stage(*stage).as_raw();
            let executable = executables.iter().find(|found| found.stages & flag != 0);
            let executable = executable.ok_or_else(|| IsaError::Refused {
                key: permutation.key.clone(),
                reason: format!("the driver says nothing of `{entry_point}`"),
            })?;
            let cost = StageCost::read(&self.options.family, (*stage, entry_point), executable);
            cost.map_err(|statistic| IsaError::Statistic {
                key: permutation.key.clone(),
                entry_point: entry_point.clone(),
                statistic,
            })
        });
        costs.collect()
    }
}

/// Costs of each of `permutations`, in their order, by up to one process a core. `done` is called after each.
///
/// # Errors
/// Where no compiler starts; what goes wrong with one permutation is its own result.
pub fn costs(
    options: &CompilerOptions,
    permutations: &[(&Permutation, PipelineState)],
    done: &(dyn Fn() + Sync),
) -> Result<Vec<Result<Vec<StageCost>, IsaError>>, IsaError> {
    let cores = thread::available_parallelism().map_or(1, usize::from);
    let count = cores
        .min(permutations.len().div_ceil(WORTH_A_PROCESS))
        .max(1);
    let next = AtomicUsize::new(0);
    let work = |mut compiler: Compiler| {
        let mut costs = Vec::new();
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some((permutation, state)) = permutations.get(index) else {
                return costs;
            };
            costs.push((index, compiler.cost(permutation, state)));
            done();
        }
    };
    // The first alone says what is wrong with all.
    let mut compilers = vec![Compiler::with(options)?];
    for _ in 1..count {
        compilers.push(Compiler::with(options)?);
    }
    let mut costs = Vec::new();
    thread::scope(|scope| {
        let workers = compilers
            .into_iter()
            .map(|compiler| scope.spawn(|| work(compiler)));
        for worker in workers.collect::<Vec<_>>() {
            match worker.join() {
                Ok(done) => costs.extend(done),
                Err(panic) => std::panic::resume_unwind(panic),
            }
        }
    });
    costs.sort_by_key(|(index, _)| *index);
    Ok(costs.into_iter().map(|(_, cost)| cost).collect())
}

/// So many permutations take about as long as a process does to start and to open its device.
const WORTH_A_PROCESS: usize = 16;

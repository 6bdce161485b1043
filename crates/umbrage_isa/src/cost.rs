//! Cost of a stage, and how it is read out of a driver's statistics.

use serde::Serialize;
use umbrage_compose::Stage;

use crate::wire::Executable;

/// Cost of one stage of a permutation.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct StageCost {
    /// The stage.
    pub stage: Stage,
    /// The name of its entry point.
    pub entry_point: String,
    /// The compiler's figures of it.
    #[serde(flatten)]
    pub isa: Isa,
    /// Room that it takes of the GPU while it runs.
    #[serde(flatten)]
    pub room: Room,
}

/// Figures of a GPU family's compiler for a shader stage: RADV's, unchanged. The crate page says what
/// they are good for.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Isa {
    /// The GPU family, such as `navi21`.
    pub family: String,
    /// Instructions, each counted once, however often it runs.
    pub instructions: u64,
    /// Vector registers of a lane that are set aside.
    pub vgprs: u64,
    /// Scalar registers of a wave that are set aside.
    pub sgprs: u64,
    /// Bytes of machine code.
    pub code_size: u64,
    /// Cycles from a wave's start to its end, stalls included, by the compiler's estimate.
    pub latency: u64,
    /// Cycles that a wave keeps the busiest unit busy, by the compiler's estimate.
    pub inverse_throughput: u64,
}

/// Room that a stage takes of the GPU while it runs, by RADV's figures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Room {
    /// Vector registers that did not fit and live in memory.
    pub spilled_vgprs: u64,
    /// Scalar registers that did not fit and live in vector registers.
    pub spilled_sgprs: u64,
    /// Bytes of memory that a workgroup shares.
    pub lds_size: u64,
    /// Bytes of memory of its own that a wave needs.
    pub scratch_size: u64,
    /// Waves that fit on one SIMD at a time.
    pub waves_per_simd: u64,
}

impl StageCost {
    /// Every figure by its name, in the order in which it is told.
    pub fn figures(&self) -> [(&'static str, u64); 11] {
        let (isa, room) = (&self.isa, &self.room);
        [
            ("instructions", isa.instructions),
            ("vgprs", isa.vgprs),
            ("sgprs", isa.sgprs),
            ("code_size", isa.code_size),
            ("latency", isa.latency),
            ("inverse_throughput", isa.inverse_throughput),
            ("spilled_vgprs", room.spilled_vgprs),
            ("spilled_sgprs", room.spilled_sgprs),
            ("lds_size", room.lds_size),
            ("scratch_size", room.scratch_size),
            ("waves_per_simd", room.waves_per_simd),
        ]
    }

    /// Reads `executable`'s statistics, or says which one it lacks.
    pub(crate) fn read(
        family: &str,
        (stage, entry_point): (Stage, &str),
        executable: &Executable,
    ) -> Result<Self, &'static str> {
        let value = |name: &'static str| {
            let mut statistics = executable.statistics.iter();
            let found = statistics.find(|(known, _)| known.eq_ignore_ascii_case(name));
            found.map(|(_, value)| *value).ok_or(name)
        };
        let isa = Isa {
            family: family.to_owned(),
            instructions: value("Instructions")?,
            vgprs: value("VGPRs")?,
            sgprs: value("SGPRs")?,
            code_size: value("Code size")?,
            latency: value("Latency")?,
            inverse_throughput: value("Inverse Throughput")?,
        };
        let room = Room {
            spilled_vgprs: value("Spilled VGPRs")?,
            spilled_sgprs: value("Spilled SGPRs")?,
            lds_size: value("LDS size")?,
            scratch_size: value("Scratch size")?,
            waves_per_simd: value("Subgroups per SIMD")?,
        };
        Ok(Self {
            stage,
            entry_point: entry_point.to_owned(),
            isa,
            room,
        })
    }
}

//! `umbrage adapter`: what scenes are rendered with.

use std::process::ExitCode;

use anyhow::Result;
use umbrage::render::Gpu;

use crate::output::print;

pub(crate) fn adapter() -> Result<ExitCode> {
    let gpu = Gpu::new()?;
    print(&format!("{}\n", gpu.adapter()))?;
    Ok(ExitCode::SUCCESS)
}

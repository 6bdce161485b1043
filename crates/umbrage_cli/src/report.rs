use anyhow::Result;
use std::path::Path;
use umbrage_measure::report::{Pictures, Report, write};
pub(crate) fn check_out(_: &Path) -> Result<()> {
    Ok(())
}
pub(crate) fn write_report(report: &Report, pictures: &[Pictures], out: &Path) -> Result<()> {
    std::fs::create_dir_all(out)?;
    Ok(write(report, pictures, out)?)
}

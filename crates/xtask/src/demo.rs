//! `cargo xtask demo`: the main job, from a bare machine to pictures.

use std::{
    path::{Path, PathBuf},
    time::Duration,
};

use anyhow::{Context, Result, bail};
use indicatif::{ProgressBar, ProgressStyle};

use crate::{
    run::{Steps, captured, root, umbrage},
    setup::set_up_command,
};

const SCENES: &str = "examples/scenes";
const MANIFEST: &str = "permutations/demo.ron";
const PICTURES: &str = "target/umbrage/demo";
const SIZE: &str = "960x540";
const REPORT: &str = "target/umbrage/report";
/// Large enough to see what differs, and small enough for a software rasteriser.
const REPORT_SIZE: &str = "480x270";
/// Enough for an interval; `umbrage compare` takes more for a narrow one.
const REPORT_PAIRS: &str = "7";

pub(crate) fn demo() -> Result<()> {
    let mut steps = Steps::new(4);
    steps.begin("set-up");
    set_up_command()?;
    steps.run("permutations", &mut umbrage(&["check", MANIFEST]))?;

    let scenes = scenes(&root().join(SCENES))?;
    steps.begin(&format!("{} scenes", scenes.len()));
    let pictures = root().join(PICTURES);
    std::fs::create_dir_all(&pictures)
        .with_context(|| format!("the folder {} could not be made", pictures.display()))?;
    let bar = ProgressBar::new(scenes.len() as u64);
    if let Ok(style) = ProgressStyle::with_template("{bar:40} {pos}/{len} {msg} {elapsed}") {
        bar.set_style(style);
    }
    bar.enable_steady_tick(Duration::from_millis(100));
    let mut files = Vec::new();
    for scene in scenes {
        let name = scene
            .file_stem()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        bar.set_message(name.clone());
        let picture = format!("{PICTURES}/{name}.png");
        let scene = format!("{SCENES}/{name}.ron");
        let mut render = umbrage(&["render", &scene, "--size", SIZE, "--out", &picture]);
        files.push(scene);
        captured(&mut render)?;
        bar.suspend(|| eprintln!("    {picture}"));
        bar.inc(1);
    }
    bar.finish_and_clear();

    let mut compare = umbrage(&["compare"]);
    compare.args(&files);
    compare.args([
        "--size",
        REPORT_SIZE,
        "--pairs",
        REPORT_PAIRS,
        "--out",
        REPORT,
    ]);
    steps.run("report", &mut compare)?;
    eprintln!("the pictures are in {}", pictures.display());
    let page = root().join(REPORT).join("report.html");
    eprintln!("which method to choose: open {}", page.display());
    Ok(())
}

/// The scene files of `folder`, by name.
fn scenes(folder: &Path) -> Result<Vec<PathBuf>> {
    let entries = std::fs::read_dir(folder)
        .with_context(|| format!("the folder {} could not be read", folder.display()))?;
    let mut scenes = Vec::new();
    for entry in entries {
        let path = entry?.path();
        if path.extension().is_some_and(|extension| extension == "ron") {
            scenes.push(path);
        }
    }
    scenes.sort();
    if scenes.is_empty() {
        bail!(
            "no scene in {}: the demo has nothing to render",
            folder.display()
        );
    }
    Ok(scenes)
}

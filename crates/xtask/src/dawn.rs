//! Dawn, WebGPU's implementation in Chrome, which the tests hold our verdicts against: from npm, where Node is.

use std::{fs, path::Path, process::Command};

use anyhow::{Context, Result};

use crate::run::{behind_spinner, captured, root};

/// The oldest version of Node that Dawn's package runs on.
const NODE: u32 = 20;
const SOURCE: &str = "tests/dawn";
/// Where the tests look for it.
const HOME: &str = "target/umbrage/dawn";

/// Installs Dawn once, and returns whether the tests have it; if not, prints why. `UMBRAGE_DAWN=off` leaves Dawn
/// out.
pub(crate) fn set_up_dawn() -> Result<bool> {
    let reason = if std::env::var("UMBRAGE_DAWN").is_ok_and(|wish| wish == "off") {
        "UMBRAGE_DAWN is `off`".to_owned()
    } else {
        match lacking(version("node"), version(npm())) {
            Some(lack) => lack,
            None => {
                install(&root().join(SOURCE), &root().join(HOME)).context(
                    "npm could not install Dawn; with UMBRAGE_DAWN=off the tests do without its verdicts",
                )?;
                eprintln!("Dawn: {HOME}");
                return Ok(true);
            }
        }
    };
    eprintln!("Dawn's verdicts on shaders are passed over: {reason}");
    Ok(false)
}

/// The missing part of Node, in words; none where nothing is missing.
fn lacking(node: Option<String>, npm: Option<String>) -> Option<String> {
    let Some(node) = node else {
        return Some(format!("there is no Node {NODE} or later here"));
    };
    let major = node.trim_start_matches('v').split('.').next();
    let major: u32 = major.and_then(|major| major.parse().ok()).unwrap_or(0);
    if major < NODE {
        return Some(format!(
            "Node here is {node}, and they need {NODE} or later"
        ));
    }
    npm.is_none()
        .then(|| "there is Node here, but no npm".to_owned())
}

/// The version that `program` tells; none where it does not run.
fn version(program: &str) -> Option<String> {
    let said = captured(Command::new(program).arg("--version")).ok()?;
    Some(String::from_utf8_lossy(&said.stdout).trim().to_owned())
}

fn npm() -> &'static str {
    if cfg!(windows) { "npm.cmd" } else { "npm" }
}

/// Installs what the lock file in `source` says into `home`, unless that is what is there.
fn install(source: &Path, home: &Path) -> Result<()> {
    let lock = fs::read_to_string(source.join("package-lock.json"))?;
    let stamp = home.join("installed");
    if fs::read_to_string(&stamp).is_ok_and(|installed| installed == lock) {
        return Ok(());
    }
    fs::create_dir_all(home)?;
    for file in ["package.json", "package-lock.json"] {
        fs::copy(source.join(file), home.join(file))?;
    }
    let mut npm = Command::new(npm());
    // Its scripts have nothing to do on the systems that we test on.
    npm.args([
        "ci",
        "--ignore-scripts",
        "--no-audit",
        "--no-fund",
        "--prefix",
    ]);
    behind_spinner("installing Dawn", npm.arg(home))?;
    // This comes last, so that an interrupted installation is begun again.
    fs::write(&stamp, lock)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missing_is_said() {
        let some = |text: &str| Some(text.to_owned());
        assert_eq!(lacking(some("v20.1.0"), some("10.0.0")), None);
        for (node, npm, part) in [
            (None, None, "no Node 20"),
            (some("v18.20.4"), some("10.0.0"), "v18.20.4"),
            (some("odd"), some("10.0.0"), "odd"),
            (some("v22.0.0"), None, "no npm"),
        ] {
            let said = lacking(node, npm).unwrap_or_default();
            assert!(said.contains(part), "{said}");
        }
    }

    #[test]
    fn what_is_installed_is_not_installed_again() {
        let home = tempfile::tempdir().expect("a folder");
        let source = root().join(SOURCE);
        let lock = fs::read_to_string(source.join("package-lock.json")).expect("a lock file");
        fs::write(home.path().join("installed"), lock).expect("written");
        install(&source, home.path()).expect("nothing to do");
        assert!(!home.path().join("package.json").exists());
    }

    /// The lock file names no registry: where packages come from is up to the user.
    #[test]
    fn the_package_asks_for_this_node_and_names_no_host() {
        let lock = root().join(SOURCE).join("package-lock.json");
        let lock = fs::read_to_string(lock).expect("a lock file");
        assert!(!lock.contains("://"), "{lock}");
        let package = root().join(SOURCE).join("package.json");
        let package = fs::read_to_string(package).expect("a package");
        assert!(package.contains(&format!("\">={NODE}\"")), "{package}");
    }
}

//! Set-up: a wgpu adapter, from Mesa's software Vulkan where the machine has none.

use std::process::{Command, Stdio};

use anyhow::{Context, Result, bail};

use crate::run::{behind_spinner, cargo, root, shell_line, umbrage, visibly};

const PACKAGES: [&str; 2] = ["libvulkan1", "mesa-vulkan-drivers"];

/// The test that passes where the command finds an adapter.
const ADAPTER_TEST: &str = "arguments::the_adapter_has_a_name";

/// Builds the command and sees to it that the machine has an adapter.
pub(crate) fn set_up_command() -> Result<()> {
    visibly(&mut cargo(&["build", "--bin", "umbrage"]))?;
    ensure_adapter(|| {
        let output = behind_spinner("looking for an adapter", &mut umbrage(&["adapter"]))?;
        Ok(String::from_utf8_lossy(&output.stdout).trim().to_owned())
    })
}

/// Builds the tests and sees to it that the machine has an adapter.
///
/// Tests ask their dependencies for features that the command alone does not: to build the command by
/// itself would build most dependencies twice. So a test that runs the command looks for the adapter.
pub(crate) fn set_up_tests() -> Result<()> {
    visibly(&mut cargo(&["test", "--no-run"]))?;
    ensure_adapter(|| {
        let mut test = cargo(&[
            "test",
            "--quiet",
            "--test",
            "cli",
            "--",
            "--exact",
            ADAPTER_TEST,
        ]);
        let output = behind_spinner("looking for an adapter", &mut test)?;
        if !String::from_utf8_lossy(&output.stdout).contains("1 passed") {
            bail!(
                "there is no test {ADAPTER_TEST} any more; name its successor in xtask's setup.rs"
            );
        }
        Ok("found".to_owned())
    })
}

/// Installs Mesa's software Vulkan where `adapter` fails.
fn ensure_adapter(adapter: impl Fn() -> Result<String>) -> Result<()> {
    match adapter() {
        Ok(adapter) => {
            eprintln!("adapter: {adapter}");
            return Ok(());
        }
        Err(reason) => eprintln!("{reason:#}"),
    }
    let commands = install_commands();
    let script = commands
        .iter()
        .map(shell_line)
        .collect::<Vec<_>>()
        .join(" && ");
    if !has_apt() {
        bail!(
            "this machine has no Vulkan adapter, and no apt-get to install one with; install a Vulkan driver \
             (Mesa's lavapipe renders without a GPU) and its loader, and run this again"
        );
    }
    if !is_root() {
        bail!(
            "this machine has no Vulkan adapter, and only root can install Mesa's software Vulkan; run\n    \
             sudo sh -c '{script}'\nand then this again"
        );
    }
    eprintln!("no adapter found; installing Mesa's software Vulkan: {script}");
    for mut command in commands {
        let what = shell_line(&command);
        behind_spinner(&what, &mut command)?;
    }
    let adapter =
        adapter().context("Mesa's software Vulkan was installed, but there is still no adapter")?;
    eprintln!("adapter: {adapter}");
    Ok(())
}

fn install_commands() -> Vec<Command> {
    let apt = |args: &[&str]| {
        let mut command = Command::new("apt-get");
        // Nothing may wait for an answer; another apt at work is waited for.
        command.args(["-o", "DPkg::Lock::Timeout=120"]).args(args);
        command.env("DEBIAN_FRONTEND", "noninteractive");
        command
    };
    let mut install = apt(&["install", "--yes", "--no-install-recommends"]);
    install.args(PACKAGES);
    vec![apt(&["update"]), install]
}

fn has_apt() -> bool {
    Command::new("apt-get")
        .arg("--version")
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .current_dir(root())
        .status()
        .is_ok_and(|status| status.success())
}

fn is_root() -> bool {
    let id = Command::new("id").arg("-u").stdin(Stdio::null()).output();
    id.is_ok_and(|id| id.stdout.trim_ascii() == b"0")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_commands_ask_nothing() {
        let lines: Vec<_> = install_commands().iter().map(shell_line).collect();
        assert_eq!(
            lines,
            [
                "DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=120 update",
                "DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=120 install --yes \
                 --no-install-recommends libvulkan1 mesa-vulkan-drivers",
            ]
        );
    }
}

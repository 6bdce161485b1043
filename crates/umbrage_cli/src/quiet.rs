//! Mesa's layer that chooses among devices asks Wayland, whose library complains on standard error where there
//! is no desktop session. The command has no window, so it turns the layer off for itself.

/// Turns the layer off (`NODEVICE_SELECT`), before Vulkan's loader looks for layers. As that takes a changed
/// environment, the command executes itself anew, with the same process number, arguments and files. Where someone
/// chooses a device by that layer, or it would not complain, it is left alone.
#[cfg(unix)]
pub(crate) fn mesa() {
    use std::{env, os::unix::process::CommandExt, path::PathBuf, process::Command};

    let session = env::var_os("XDG_RUNTIME_DIR").map(PathBuf::from);
    let complains = !session.is_some_and(|folder| folder.is_absolute());
    let asked = ["NODEVICE_SELECT", "MESA_VK_DEVICE_SELECT"];
    if !complains || asked.iter().any(|name| env::var_os(name).is_some()) {
        return;
    }
    let mut words = env::args_os();
    if let (Ok(program), Some(name)) = (env::current_exe(), words.next()) {
        // A failure does no harm: the library's complaint is then printed.
        let _ = Command::new(program)
            .arg0(name)
            .args(words)
            .env("NODEVICE_SELECT", "1")
            .exec();
    }
}

#[cfg(not(unix))]
pub(crate) fn mesa() {}

//! Folders of a passing name, in which something is made: held by a lock, so that those that a process which
//! was killed left behind can be told from those that one is just filling.

use std::{
    ffi::OsStr,
    fs::{self, File},
    io,
    path::Path,
};

use tempfile::TempDir;

/// Random letters of a passing name.
const LETTERS: usize = 6;

/// A folder that goes with this value, and that no other process takes for one left behind.
pub(crate) struct Passing {
    folder: TempDir,
    /// Closed, it is unlocked: the system does so for a process that ends in whatever way.
    _lock: Option<File>,
}

impl Passing {
    /// A new folder in `parent`, open to whom the process's umask allows. Its name begins with `.NAME-`.
    pub(crate) fn new(parent: &Path, name: &str) -> io::Result<Self> {
        loop {
            let folder = tempdir(parent, name)?;
            let Some(lock) = lock(folder.path(), File::lock) else {
                // Where folders cannot be locked, none is swept either.
                return Ok(Self {
                    folder,
                    _lock: None,
                });
            };
            // Until it was locked, another process may have taken it for one left behind.
            if folder.path().exists() {
                return Ok(Self {
                    folder,
                    _lock: Some(lock),
                });
            }
        }
    }

    pub(crate) fn path(&self) -> &Path {
        self.folder.path()
    }
}

/// Removes the folders in `parent` that [`Passing`] made by this name and that no process holds any more. One
/// that holds other files than `own` ones stays, as does what cannot be read or removed.
pub(crate) fn sweep(parent: &Path, name: &str, own: fn(&str) -> bool) {
    let prefix = format!(".{name}-");
    let passing = |file: &OsStr| {
        let letters = file.to_str().and_then(|file| file.strip_prefix(&prefix));
        letters.is_some_and(|letters| {
            letters.len() == LETTERS && letters.bytes().all(|byte| byte.is_ascii_alphanumeric())
        })
    };
    let entries = fs::read_dir(parent).into_iter().flatten().flatten();
    for entry in entries.filter(|entry| passing(&entry.file_name())) {
        let path = entry.path();
        if !entry.file_type().is_ok_and(|kind| kind.is_dir()) {
            continue;
        }
        let try_lock = |file: &File| file.try_lock().map_err(io::Error::from);
        if let Some(_held) = lock(&path, try_lock)
            && holds_only(&path, own)
        {
            // Another process may be sweeping as well.
            let _ = fs::remove_dir_all(&path);
        }
    }
}

fn tempdir(parent: &Path, name: &str) -> io::Result<TempDir> {
    let prefix = format!(".{name}-");
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix).rand_bytes(LETTERS);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o777));
    }
    builder.tempdir_in(parent)
}

/// The folder `path`, locked; none where that cannot be.
fn lock(path: &Path, lock: impl Fn(&File) -> io::Result<()>) -> Option<File> {
    let file = File::open(path).ok()?;
    lock(&file).ok()?;
    Some(file)
}

fn holds_only(folder: &Path, own: fn(&str) -> bool) -> bool {
    let is_own = |entry: io::Result<fs::DirEntry>| {
        entry.is_ok_and(|entry| {
            entry.file_type().is_ok_and(|kind| kind.is_file())
                && entry.file_name().to_str().is_some_and(own)
        })
    };
    fs::read_dir(folder).is_ok_and(|mut entries| entries.all(is_own))
}

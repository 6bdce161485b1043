//! Temporary folders, in which something is made. Each is locked while it is filled: so folders that a killed
//! process left behind can be told from folders in use.

use std::{
    ffi::OsStr,
    fs::{self, File},
    io,
    path::Path,
};

use tempfile::TempDir;

/// Number of random letters in a temporary folder's name.
const LETTERS: usize = 6;

/// A temporary folder, removed when this value is dropped; no other process takes it for one left behind.
pub(crate) struct Passing {
    folder: TempDir,
    /// Closing the file unlocks the folder; the system closes it however the process ends.
    _lock: Option<File>,
}

impl Passing {
    /// A new folder in `parent`, with the permissions that the process's umask leaves. Its name begins with `.NAME-`.
    pub(crate) fn new(parent: &Path, name: &str) -> io::Result<Self> {
        loop {
            let folder = tempdir(parent, name)?;
            let Some(lock) = lock(folder.path(), File::lock) else {
                // Where folders cannot be locked, none is swept: this one needs no lock.
                return Ok(Self {
                    folder,
                    _lock: None,
                });
            };
            // Before it was locked, another process may have swept it as left behind.
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

/// Removes the folders in `parent` that [`Passing`] made by this name and that no process holds any more. A folder
/// with files other than `own` ones stays, and so does one that cannot be read or removed.
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

/// The folder `path`, locked; none where it cannot be.
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

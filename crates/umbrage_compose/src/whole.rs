//! Atomic writes: a file is written whole or not at all.

use std::{
    fs::{self, File},
    io::{self, Write as _},
    path::Path,
};

/// Temporary file's name: [`PREFIX`], then random letters, then [`SUFFIX`].
const PREFIX: &str = ".umbrage-";
const LETTERS: usize = 12;
const SUFFIX: &str = ".part";

/// Writes the file `path`, with the permissions that the process's umask allows. The bytes go to a temporary file
/// in the same folder, which is then renamed, so that others see the old file or the whole new one, even where the
/// process is killed.
///
/// # Errors
/// A folder that does not exist, is full or cannot be written to.
pub fn write_whole(path: &Path, bytes: &[u8]) -> io::Result<()> {
    write_whole_by(path, |file| file.write_all(bytes))
}

/// The same of what `write` writes.
pub(crate) fn write_whole_by(
    path: &Path,
    write: impl FnOnce(&mut File) -> io::Result<()>,
) -> io::Result<()> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(PREFIX).rand_bytes(LETTERS).suffix(SUFFIX);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    loop {
        let mut file = builder.tempfile_in(folder_of(path))?;
        // Where files cannot be locked, `sweep_beside` removes none either.
        let _ = file.as_file().lock();
        // Before this lock, another process may have taken the file for one left behind, and removed it.
        if !file.path().exists() {
            continue;
        }
        write(file.as_file_mut())?;
        return file.persist(path).map(drop).map_err(|error| error.error);
    }
}

/// Removes the temporary files that killed processes left in the folder of `path` from their calls of
/// [`write_whole`]. Files that a process is still writing stay, as do those that cannot be removed.
pub fn sweep_beside(path: &Path) {
    let entries = fs::read_dir(folder_of(path)).into_iter().flatten();
    for entry in entries.flatten() {
        let name = entry.file_name();
        let letters =
            (name.to_str()).and_then(|name| name.strip_prefix(PREFIX)?.strip_suffix(SUFFIX));
        let ours = letters.is_some_and(|letters| letters.len() == LETTERS);
        if ours
            && let Ok(file) = File::open(entry.path())
            && file.try_lock().is_ok()
        {
            // Another process may have removed it first.
            let _ = fs::remove_file(entry.path());
        }
    }
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> = fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn a_file_takes_the_place_of_another_and_leaves_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        write_whole(&path, b"old").unwrap();
        write_whole(&path, b"new").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(names(folder.path()), ["a.png"]);
        assert!(write_whole(&folder.path().join("gone/a.png"), b"").is_err());
        fs::create_dir(folder.path().join("b.png")).unwrap();
        assert!(write_whole(&folder.path().join("b.png"), b"").is_err());
        assert_eq!(names(folder.path()), ["a.png", "b.png"]);
    }

    #[test]
    fn what_no_process_holds_is_swept() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        for name in [
            ".umbrage-abcdefghijkl.part",
            ".umbrage-mnopqrstuvwx.part",
            ".umbrage-mine.part",
            "a.part",
        ] {
            fs::write(path(name), "half").unwrap();
        }
        let held = File::open(path(".umbrage-mnopqrstuvwx.part")).unwrap();
        held.lock().unwrap();
        sweep_beside(&path("a.png"));
        assert_eq!(
            names(folder.path()),
            [".umbrage-mine.part", ".umbrage-mnopqrstuvwx.part", "a.part"]
        );
        drop(held);
        sweep_beside(&path("a.png"));
        assert_eq!(names(folder.path()), [".umbrage-mine.part", "a.part"]);
    }
}

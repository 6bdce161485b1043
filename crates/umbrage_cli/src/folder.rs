//! Folders that are written whole or not at all.

use std::{fs, io, path::Path};

use anyhow::{Context, Result, bail};
use tempfile::TempDir;

use crate::interrupt;

/// What a folder holds.
pub(crate) struct Kind {
    /// One of them: `prebuild`.
    pub(crate) name: &'static str,
    /// An error that says what in a folder, which is not empty, is no such thing's.
    pub(crate) check: fn(&Path) -> Result<()>,
}

impl Kind {
    /// Refuses to replace a folder unless all that it holds is this kind's own.
    pub(crate) fn check_replaceable(&self, out: &Path) -> Result<()> {
        let first = match fs::read_dir(out) {
            Ok(mut entries) => entries.next().transpose(),
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
            Err(error) => Err(error),
        };
        let first =
            first.with_context(|| format!("{} cannot be used as a folder", out.display()))?;
        if first.is_none() {
            return Ok(());
        }
        if let Err(reason) = (self.check)(out) {
            bail!(
                "the folder {} holds what is no {name}: {reason:#}; nothing in it was touched. Name a new or \
                 empty folder with --out, or move away what is not the {name}'s",
                out.display(),
                name = self.name,
            );
        }
        Ok(())
    }

    /// Lets `fill` write files into a new folder beside `out`, and then puts it in the place of `out`: a
    /// half-written folder is never seen, and none is left behind by a fault or by Ctrl-C. `fill` may ask
    /// [`interrupt::check`] between its files.
    pub(crate) fn replace(&self, out: &Path, fill: impl FnOnce(&Path) -> Result<()>) -> Result<()> {
        // Dropped last, after the folders below are removed.
        let _writing = interrupt::writing();
        interrupt::check()?;
        let written = self.write(out, fill);
        if written.is_err() {
            // What was broken off is no fault of the folder's.
            interrupt::check()?;
        }
        written.with_context(|| {
            format!(
                "the folder {} could not be written; choose one where new folders can be made, and with \
                 room enough",
                out.display()
            )
        })
    }

    fn write(&self, out: &Path, fill: impl FnOnce(&Path) -> Result<()>) -> Result<()> {
        let out = std::path::absolute(out)?;
        let parent = out.parent().context("it has no parent folder")?;
        fs::create_dir_all(parent)
            .with_context(|| format!("its parent {} could not be made", parent.display()))?;
        let fresh = self.sibling(parent)?;
        fill(fresh.path())?;
        interrupt::check()?;
        // The work before took a while, in which someone may have put a file there.
        self.check_replaceable(&out)?;
        let aside = self.sibling(parent)?;
        self.put_in_place(fresh.path(), &out, aside, |from, to| fs::rename(from, to))
    }

    /// Renames `fresh` to `out`. An old `out` steps into `aside` first, as a rename does not replace a
    /// folder with files; it is removed only when the new one stands.
    fn put_in_place(
        &self,
        fresh: &Path,
        out: &Path,
        aside: TempDir,
        rename: impl Fn(&Path, &Path) -> io::Result<()>,
    ) -> Result<()> {
        let old = aside.path().join("old");
        let had_old = out.exists();
        if had_old {
            rename(out, &old)?;
        }
        let Err(error) = rename(fresh, out) else {
            return Ok(());
        };
        if had_old && let Err(restoring) = rename(&old, out) {
            let kept = aside.keep().join("old");
            return Err(error).with_context(|| {
                format!(
                    "the earlier {} could not be put back either ({restoring}): it is in {}; move it back \
                     by hand",
                    self.name,
                    kept.display()
                )
            });
        }
        Err(error.into())
    }

    /// A folder of a passing name in `parent`, open to whom the process's umask allows.
    fn sibling(&self, parent: &Path) -> io::Result<TempDir> {
        let prefix = format!(".{}-", self.name);
        let mut builder = tempfile::Builder::new();
        builder.prefix(&prefix);
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            builder.permissions(fs::Permissions::from_mode(0o777));
        }
        builder.tempdir_in(parent)
    }
}

/// Writes a file of a folder; an error names it.
pub(crate) fn store(folder: &Path, file: &str, contents: impl AsRef<[u8]>) -> Result<()> {
    interrupt::check()?;
    fs::write(folder.join(file), contents).with_context(|| format!("{file} could not be written"))
}

#[cfg(test)]
mod tests {
    use super::*;

    const PREBUILD: Kind = Kind {
        name: "prebuild",
        check: |folder| match folder.join("file").is_file() {
            true => Ok(()),
            false => bail!("no file"),
        },
    };

    /// An old prebuild and a new one, and renames of which those that `fails` names do nothing.
    fn replaced(fails: fn(&Path, &Path) -> bool) -> (TempDir, Result<()>) {
        let folder = TempDir::new().expect("a folder");
        let (fresh, out) = (folder.path().join("fresh"), folder.path().join("out"));
        for (path, text) in [(&fresh, "new"), (&out, "old")] {
            fs::create_dir(path).expect("a folder");
            fs::write(path.join("file"), text).expect("a file");
        }
        let aside = PREBUILD.sibling(folder.path()).expect("a folder");
        let done = PREBUILD.put_in_place(&fresh, &out, aside, |from, to| {
            if fails(from, to) {
                return Err(io::Error::other("no"));
            }
            fs::rename(from, to)
        });
        (folder, done)
    }

    fn text(folder: &TempDir) -> Option<String> {
        fs::read_to_string(folder.path().join("out/file")).ok()
    }

    #[test]
    fn the_new_folder_takes_the_place_of_the_old() {
        let (folder, done) = replaced(|_, _| false);
        assert!(done.is_ok());
        assert_eq!(text(&folder).as_deref(), Some("new"));
        assert_eq!(fs::read_dir(folder.path()).expect("listed").count(), 1);
    }

    #[test]
    fn the_old_folder_is_put_back() {
        let (folder, done) = replaced(|from, _| from.ends_with("fresh"));
        assert!(done.is_err());
        assert_eq!(text(&folder).as_deref(), Some("old"));
    }

    #[test]
    fn what_cannot_be_put_back_is_kept_and_told() {
        let (folder, done) = replaced(|_, to| to.ends_with("out"));
        let said = format!("{:#}", done.expect_err("no rename"));
        assert_eq!(text(&folder), None);
        let kept = fs::read_dir(folder.path())
            .expect("listed")
            .map(|entry| entry.expect("an entry").path().join("old"))
            .find(|path| path.is_dir())
            .expect("the old folder is kept");
        assert!(said.contains(&kept.display().to_string()), "{said}");
        assert_eq!(fs::read_to_string(kept.join("file")).expect("read"), "old");
    }

    #[test]
    fn a_fault_while_filling_leaves_what_was() {
        let folder = TempDir::new().expect("a folder");
        let out = folder.path().join("out");
        fs::create_dir(&out).expect("a folder");
        fs::write(out.join("file"), "old").expect("a file");
        let done = PREBUILD.replace(&out, |fresh| {
            store(fresh, "file", "new")?;
            bail!("no room")
        });
        assert!(format!("{:#}", done.expect_err("a fault")).contains("no room"));
        assert_eq!(text(&folder).as_deref(), Some("old"));
        assert_eq!(fs::read_dir(folder.path()).expect("listed").count(), 1);
    }

    /// What the test below runs in a process of its own: writes a file, says so, and dawdles.
    #[test]
    #[ignore = "run by an_interrupt_while_writing_leaves_what_was"]
    fn slow_writer() {
        let Some(out) = std::env::var_os("UMBRAGE_TEST_OUT") else {
            return;
        };
        interrupt::install().expect("a handler");
        let done = PREBUILD.replace(Path::new(&out), |fresh| {
            store(fresh, "file", "new")?;
            for _ in 0..600 {
                std::thread::sleep(std::time::Duration::from_millis(50));
                interrupt::check()?;
            }
            Ok(())
        });
        assert!(done.is_err());
        // The handler ends the process.
        std::thread::sleep(std::time::Duration::from_secs(30));
    }

    #[cfg(unix)]
    #[test]
    fn an_interrupt_while_writing_leaves_what_was() {
        use std::{process::Command, time::Duration};

        for (signal, old) in [("INT", true), ("TERM", true), ("INT", false)] {
            let folder = TempDir::new().expect("a folder");
            let out = folder.path().join("out");
            if old {
                fs::create_dir(&out).expect("a folder");
                fs::write(out.join("file"), "old").expect("a file");
            }
            let mut child = Command::new(std::env::current_exe().expect("this test"))
                .args(["folder::tests::slow_writer", "--exact", "--ignored"])
                .env("UMBRAGE_TEST_OUT", &out)
                .stdout(std::process::Stdio::null())
                .spawn()
                .expect("a process");
            let names = || -> Vec<_> {
                fs::read_dir(folder.path())
                    .expect("listed")
                    .map(|entry| entry.expect("an entry").path())
                    .collect()
            };
            let begun = || {
                names()
                    .iter()
                    .any(|path| path != &out && path.join("file").is_file())
            };
            let mut turns = 0;
            while !begun() {
                turns += 1;
                assert!(turns < 600, "nothing is written");
                std::thread::sleep(Duration::from_millis(50));
            }
            let killed = Command::new("kill")
                .args([format!("-{signal}"), child.id().to_string()])
                .status();
            assert!(killed.expect("kill").success());
            let status = child.wait().expect("an end");
            assert_eq!(status.code(), Some(interrupt::STATUS.into()), "{signal}");
            assert_eq!(text(&folder).as_deref(), old.then_some("old"));
            assert_eq!(names(), if old { vec![out] } else { vec![] });
        }
    }
}

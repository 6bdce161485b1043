//! Folders that are written whole or not at all.

use std::{
    ffi::OsString,
    fs, io,
    path::{Path, PathBuf},
};

use anyhow::{Context, Result, bail};

use crate::{
    interrupt,
    passing::{Passing, sweep},
};

/// Kind of a folder's contents.
pub(crate) struct Kind {
    /// One of them: `prebuild`.
    pub(crate) name: &'static str,
    /// An error that says what in a folder, which is not empty, is no such thing's.
    pub(crate) check: fn(&Path) -> Result<()>,
    /// Whether one of its files has this name.
    pub(crate) own: fn(&str) -> bool,
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
    /// half-written folder is never seen, and none is left behind by a fault or by Ctrl-C. If the process is killed,
    /// the old folder stands there, or the new one; the next process that writes there removes everything else that
    /// was left. `fill` may call [`interrupt::check`] between its files.
    pub(crate) fn replace(&self, out: &Path, fill: impl FnOnce(&Path) -> Result<()>) -> Result<()> {
        // Dropped last, after the folders below are removed.
        let _writing = interrupt::writing();
        interrupt::check()?;
        let written = self.write(out, fill);
        if written.is_err() {
            // An interruption is no fault of the folder's.
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
        self.clear_up(&out, parent)?;
        let fresh = Passing::new(parent, self.name)?;
        fill(fresh.path())?;
        interrupt::check()?;
        // The work before took a while, in which someone may have put a file there.
        self.check_replaceable(&out)?;
        self.put_in_place(fresh.path(), &out, &Files)
    }

    /// Exchanges `fresh` for `out`: an old `out` is then where `fresh` was, and goes with it.
    ///
    /// Where the system cannot exchange two folders, the old one steps aside first, and for a moment none stands
    /// there. A process that is killed just then leaves it to [`Self::clear_up`] to put the old one back.
    fn put_in_place(&self, fresh: &Path, out: &Path, files: &dyn FileSystem) -> Result<()> {
        if !out.exists() {
            return Ok(files.rename(fresh, out)?);
        }
        if files.exchange(fresh, out)? {
            return Ok(());
        }
        let aside = self.aside(out)?;
        files.rename(out, &aside)?;
        let Err(error) = files.rename(fresh, out) else {
            // The next replacement sweeps whatever cannot be removed now.
            let _ = fs::remove_dir_all(&aside);
            return Ok(());
        };
        if let Err(restoring) = files.rename(&aside, out) {
            return Err(error).with_context(|| {
                format!(
                    "the earlier {} could not be put back either ({restoring}): it is in {}; move it back \
                     by hand",
                    self.name,
                    aside.display()
                )
            });
        }
        Err(error.into())
    }

    /// Removes the folders that killed processes left in `parent`, and puts back an earlier `out` that one moved aside.
    fn clear_up(&self, out: &Path, parent: &Path) -> Result<()> {
        sweep(parent, self.name, self.own);
        let aside = self.aside(out)?;
        if aside.is_dir() && (self.check)(&aside).is_ok() {
            match out.exists() {
                true => fs::remove_dir_all(&aside)?,
                false => fs::rename(&aside, out)?,
            }
        }
        Ok(())
    }

    /// The path to which an earlier `out` is moved aside.
    fn aside(&self, out: &Path) -> Result<PathBuf> {
        let name = out.file_name().context("it has no name")?;
        let mut aside = OsString::from(format!(".{}-before-", self.name));
        aside.push(name);
        Ok(out.with_file_name(aside))
    }
}

/// The steps by which a folder comes to its place.
trait FileSystem {
    fn rename(&self, from: &Path, to: &Path) -> io::Result<()>;

    /// Puts each of two folders in the other's place at once; false where the system cannot.
    fn exchange(&self, a: &Path, b: &Path) -> io::Result<bool>;
}

struct Files;

impl FileSystem for Files {
    fn rename(&self, from: &Path, to: &Path) -> io::Result<()> {
        fs::rename(from, to)
    }

    #[cfg(any(target_os = "linux", target_os = "android", target_vendor = "apple"))]
    fn exchange(&self, a: &Path, b: &Path) -> io::Result<bool> {
        use rustix::{
            fs::{CWD, RenameFlags, renameat_with},
            io::Errno,
        };
        match renameat_with(CWD, a, CWD, b, RenameFlags::EXCHANGE) {
            Ok(()) => Ok(true),
            Err(Errno::NOSYS | Errno::INVAL | Errno::NOTSUP) => Ok(false),
            Err(error) => Err(error.into()),
        }
    }

    #[cfg(not(any(target_os = "linux", target_os = "android", target_vendor = "apple")))]
    fn exchange(&self, _: &Path, _: &Path) -> io::Result<bool> {
        Ok(false)
    }
}

#[cfg(test)]
mod tests {
    use tempfile::TempDir;

    use super::*;

    const PREBUILD: Kind = Kind {
        name: "prebuild",
        check: |folder| match folder.join("file").is_file() {
            true => Ok(()),
            false => bail!("no file"),
        },
        own: |name| name == "file",
    };

    fn store(folder: &Path, file: &str, contents: &str) -> Result<()> {
        Ok(fs::write(folder.join(file), contents)?)
    }

    /// A file system that fails at the steps the test chooses.
    struct Told<'a> {
        exchanges: bool,
        /// Called before each step; says whether it fails.
        fails: &'a dyn Fn(&Path, &Path) -> bool,
    }

    impl FileSystem for Told<'_> {
        fn rename(&self, from: &Path, to: &Path) -> io::Result<()> {
            match (self.fails)(from, to) {
                true => Err(io::Error::other("no")),
                false => Files.rename(from, to),
            }
        }

        fn exchange(&self, a: &Path, b: &Path) -> io::Result<bool> {
            match (self.exchanges, (self.fails)(a, b)) {
                (false, _) => Ok(false),
                (true, true) => Err(io::Error::other("no")),
                (true, false) => Files.exchange(a, b),
            }
        }
    }

    /// Replaces an old prebuild with a new one; the steps that `fails` names do nothing.
    fn replaced(exchanges: bool, fails: fn(&Path, &Path) -> bool) -> (TempDir, Result<()>) {
        let folder = TempDir::new().expect("a folder");
        let out = folder.path().join("out");
        let fresh = Passing::new(folder.path(), PREBUILD.name).expect("a folder");
        fs::create_dir(&out).expect("a folder");
        for (path, text) in [(fresh.path(), "new"), (&out, "old")] {
            fs::write(path.join("file"), text).expect("a file");
        }
        let told = Told {
            exchanges,
            fails: &fails,
        };
        let done = PREBUILD.put_in_place(fresh.path(), &out, &told);
        (folder, done)
    }

    fn text(folder: &TempDir) -> Option<String> {
        fs::read_to_string(folder.path().join("out/file")).ok()
    }

    fn count(folder: &TempDir) -> usize {
        fs::read_dir(folder.path()).expect("listed").count()
    }

    #[test]
    fn the_new_folder_takes_the_place_of_the_old() {
        for exchanges in [true, false] {
            let (folder, done) = replaced(exchanges, |_, _| false);
            assert!(done.is_ok());
            assert_eq!(text(&folder).as_deref(), Some("new"));
            assert_eq!(count(&folder), 1);
        }
    }

    #[test]
    fn the_old_folder_stays_or_is_put_back() {
        for exchanges in [true, false] {
            let (folder, done) = replaced(exchanges, |from, to| {
                to.ends_with("out") && !from.to_string_lossy().contains("before")
            });
            assert!(done.is_err());
            assert_eq!(text(&folder).as_deref(), Some("old"));
            assert_eq!(count(&folder), 1);
        }
    }

    #[test]
    fn what_cannot_be_put_back_is_kept_and_told() {
        let (folder, done) = replaced(false, |_, to| to.ends_with("out"));
        let said = format!("{:#}", done.expect_err("no rename"));
        assert_eq!(text(&folder), None);
        let kept = folder.path().join(".prebuild-before-out");
        assert!(said.contains(&kept.display().to_string()), "{said}");
        assert_eq!(fs::read_to_string(kept.join("file")).expect("read"), "old");
    }

    fn write_new(out: &Path) {
        let done = PREBUILD.replace(out, |fresh| store(fresh, "file", "new"));
        done.expect("written");
    }

    /// The process that the test below runs, which stops before step `UMBRAGE_TEST_STEP`.
    #[test]
    #[ignore = "run by a_kill_at_any_step_leaves_a_whole_folder"]
    fn writer_that_stops() {
        let Some(out) = std::env::var_os("UMBRAGE_TEST_OUT") else {
            return;
        };
        let asked = std::env::var("UMBRAGE_TEST_STEP").expect("a step");
        let (kind, step) = asked.split_once('-').expect("a kind and a number");
        let stop: usize = step.parse().expect("a number");
        let step = std::cell::Cell::new(0);
        let reach = |_: &Path, _: &Path| {
            if step.replace(step.get() + 1) == stop {
                println!("stopped");
                std::thread::sleep(std::time::Duration::from_secs(60));
            }
            false
        };
        let out = Path::new(&out);
        let parent = out.parent().expect("a parent");
        PREBUILD.clear_up(out, parent).expect("cleared up");
        let fresh = Passing::new(parent, PREBUILD.name).expect("a folder");
        reach(out, out);
        store(fresh.path(), "file", "new").expect("a file");
        reach(out, out);
        let told = Told {
            exchanges: kind == "exchange",
            fails: &reach,
        };
        PREBUILD
            .put_in_place(fresh.path(), out, &told)
            .expect("in place");
        reach(out, out);
    }

    #[test]
    fn a_kill_at_any_step_leaves_a_whole_folder() {
        use std::{
            io::{BufRead, BufReader},
            process::{Command, Stdio},
        };

        for (step, left) in [
            ("exchange-0", Some("old")),
            ("exchange-1", Some("old")),
            ("exchange-2", Some("old")),
            ("exchange-3", Some("new")),
            ("rename-3", Some("old")),
            // Where folders cannot be exchanged, the old one is aside here.
            ("rename-4", None),
            ("rename-5", Some("new")),
        ] {
            let folder = TempDir::new().expect("a folder");
            let out = folder.path().join("out");
            fs::create_dir(&out).expect("a folder");
            fs::write(out.join("file"), "old").expect("a file");
            let mut child = Command::new(std::env::current_exe().expect("this test"))
                .args(["folder::tests::writer_that_stops", "--exact", "--ignored"])
                .arg("--nocapture")
                .env("UMBRAGE_TEST_OUT", &out)
                .env("UMBRAGE_TEST_STEP", step)
                .stdout(Stdio::piped())
                .spawn()
                .expect("a process");
            let lines = BufReader::new(child.stdout.take().expect("its output")).lines();
            let mut lines = lines.map_while(Result::ok);
            assert!(lines.any(|line| line.ends_with("stopped")), "{step}");
            assert_eq!(text(&folder).as_deref(), left, "{step}");
            // Folders that a living process holds are not swept.
            let held = count(&folder);
            sweep(folder.path(), PREBUILD.name, PREBUILD.own);
            let is_old_tree = step == "exchange-3";
            assert_eq!(count(&folder), if is_old_tree { 1 } else { held }, "{step}");
            child.kill().expect("killed");
            child.wait().expect("an end");
            assert_eq!(text(&folder).as_deref(), left, "{step}");
            // A writer that fails leaves the earlier folder, put back where need be.
            let failed = PREBUILD.replace(&out, |_| bail!("no room"));
            assert!(failed.is_err());
            assert_eq!(text(&folder).as_deref(), left.or(Some("old")), "{step}");
            assert_eq!(count(&folder), 1, "{step}");
            write_new(&out);
            assert_eq!(text(&folder).as_deref(), Some("new"), "{step}");
            assert_eq!(count(&folder), 1, "{step}");
        }
    }

    #[test]
    fn folders_of_others_are_not_swept() {
        let folder = TempDir::new().expect("a folder");
        let names = [
            ".prebuild-abcdef",
            ".prebuild-notes",
            ".prebuild-before-else",
            "prebuild-abcdef",
        ];
        for name in names {
            fs::create_dir(folder.path().join(name)).expect("a folder");
            fs::write(folder.path().join(name).join("mine.txt"), "mine").expect("a file");
        }
        write_new(&folder.path().join("out"));
        assert_eq!(count(&folder), names.len() + 1);
        // A folder left behind, with only a prebuild's files in it, is swept.
        let left = folder.path().join(".prebuild-abc123");
        fs::create_dir(&left).expect("a folder");
        fs::write(left.join("file"), "half").expect("a file");
        write_new(&folder.path().join("out"));
        assert_eq!(count(&folder), names.len() + 1);
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

    /// Writer that the test below runs in a process of its own: writes a file, says so, and dawdles.
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

//! Where a report is written.

use std::path::Path;

use anyhow::Result;
use umbrage_measure::report::{FILES, Pictures, Report, check_earlier, write};

use crate::folder::Kind;

const REPORT: Kind = Kind {
    name: "report",
    check: |folder| Ok(check_earlier(folder)?),
    own: |name| FILES.contains(&name),
};

/// Says at once, rather than after the work, where a report would take the place of something else.
pub(crate) fn check_out(out: &Path) -> Result<()> {
    REPORT.check_replaceable(out)
}

/// Writes the report's files into the folder `out`, in the place of an earlier report.
pub(crate) fn write_report(report: &Report, pictures: &[Pictures], out: &Path) -> Result<()> {
    REPORT.replace(out, |folder| Ok(write(report, pictures, folder)?))
}

#[cfg(test)]
mod tests {
    use std::{fs, path::PathBuf};

    use tempfile::TempDir;
    use umbrage_measure::report::{Row, difference};

    use super::*;

    /// A report of one row, and its pictures, which are `side` pixels wide and do not compress.
    fn report(config: &str, side: u32) -> (Report, Vec<Pictures>) {
        let row = Row {
            scene: "scene".to_owned(),
            method: "basic".to_owned(),
            config: config.to_owned(),
            ..Row::default()
        };
        let mut state = 1_u32;
        let noise: Vec<f32> = (0..side * side)
            .map(|_| {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                (state >> 16) as f32 / 65_536.0
            })
            .collect();
        let truth: Vec<_> = noise.iter().copied().map(Some).collect();
        let compared = vec![true; noise.len()];
        let difference = difference(&truth, &noise, &compared, side, side).expect("of one size");
        let pictures = Pictures::new(&truth, &noise, difference, None);
        let report = Report {
            rows: vec![row],
            ..Report::default()
        };
        (report, vec![pictures.expect("pictures")])
    }

    fn write_one(config: &str, side: u32, out: &Path) -> Result<()> {
        let (report, pictures) = report(config, side);
        write_report(&report, &pictures, out)
    }

    fn names(folder: &Path) -> Vec<PathBuf> {
        let entries = fs::read_dir(folder).expect("listed");
        let mut names: Vec<_> = entries
            .map(|entry| entry.expect("an entry").path())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn an_earlier_report_is_replaced_and_nothing_else_is() {
        let folder = TempDir::new().expect("a folder");
        let out = folder.path().join("deep/out");
        check_out(&out).expect("a new folder");
        write_one("first", 4, &out).expect("written");
        check_out(&out).expect("an earlier report");
        write_one("second", 4, &out).expect("written");
        let page = fs::read_to_string(out.join("report.html")).expect("a page");
        assert!(page.contains("second") && !page.contains("first<"));
        assert_eq!(
            names(&folder.path().join("deep")),
            std::slice::from_ref(&out)
        );

        fs::write(out.join("notes.txt"), "mine").expect("written");
        for said in [
            check_out(&out).expect_err("refused"),
            write_one("third", 4, &out).expect_err("refused"),
        ] {
            let said = format!("{said:#}");
            assert!(
                said.contains("no report") && said.contains("notes.txt"),
                "{said}"
            );
        }
        assert_eq!(names(&out).len(), 3);
        assert_eq!(
            fs::read_to_string(out.join("report.html")).expect("read"),
            page
        );
        assert_eq!(names(&folder.path().join("deep")), [out]);
    }

    #[test]
    fn nothing_to_report_leaves_the_earlier_report() {
        let folder = TempDir::new().expect("a folder");
        let out = folder.path().join("out");
        write_one("first", 4, &out).expect("written");
        let said = write_report(&Report::default(), &[], &out).expect_err("refused");
        assert!(
            format!("{said:#}").contains("nothing to report"),
            "{said:#}"
        );
        assert_eq!(names(&out).len(), 2);
        assert_eq!(names(folder.path()), [out]);
    }

    /// Writer that the test below runs where files may not grow.
    #[test]
    #[ignore = "run by a_full_disk_leaves_the_earlier_report"]
    fn writer_on_a_full_disk() {
        let Some(out) = std::env::var_os("UMBRAGE_TEST_OUT") else {
            return;
        };
        let said = write_one("second", 160, Path::new(&out)).expect_err("no room");
        eprintln!("said: {said:#}");
    }

    /// A limit on the size of files stands for the full disk: the same write fails, at the same place.
    #[cfg(unix)]
    #[test]
    fn a_full_disk_leaves_the_earlier_report() {
        let folder = TempDir::new().expect("a folder");
        let out = folder.path().join("out");
        write_one("first", 4, &out).expect("written");
        let before = fs::read(out.join("report.html")).expect("a page");
        // The signal that comes with the limit would end the process; a full disk sends none.
        let output = std::process::Command::new("sh")
            .args(["-c", r#"trap "" XFSZ; ulimit -f 80; exec "$0" "$@""#])
            .arg(std::env::current_exe().expect("this test"))
            .args([
                "report::tests::writer_on_a_full_disk",
                "--exact",
                "--ignored",
            ])
            .arg("--nocapture")
            .env("UMBRAGE_TEST_OUT", &out)
            .output()
            .expect("a shell");
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{said}");
        assert!(said.contains("report.html could not be written"), "{said}");
        assert!(said.contains(&out.display().to_string()), "{said}");
        assert_eq!(fs::read(out.join("report.html")).expect("a page"), before);
        assert_eq!(names(folder.path()), [out]);
    }
}

//! Records: keys of permutations that runs of programs needed, in a file that many runs add to.
//!
//! A line is a key and a checksum of it. A run adds its lines by one write at the file's end, so that several may do so at
//! once; a line that a killed run left half written is told by its checksum and passed over, with a warning.

use std::{
    collections::BTreeSet,
    fs::{self, OpenOptions},
    io::{self, Read as _, Seek as _, SeekFrom, Write as _},
    path::Path,
};

use crate::{Cause, Error, Fault, ProjectedKey, file::unreadable};

/// Keys of a record, as text, and warnings about lines that were passed over.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Record {
    /// The keys.
    pub keys: BTreeSet<String>,
    /// Warnings.
    pub warnings: Vec<String>,
}

/// Adds `keys` to the record at `path`, which is made where there is none; those that it has already are not added again.
///
/// # Errors
/// A file that cannot be read or written to.
///
/// ```
/// # use umbrage_compose::record;
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("run.record");
/// record::append(&path, &[])?;
/// assert!(record::read(&path)?.keys.is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn append(path: &Path, keys: &[ProjectedKey]) -> Result<(), Error> {
    let known = match path.exists() {
        true => read(path)?.keys,
        false => BTreeSet::new(),
    };
    let keys = keys.iter().map(ToString::to_string);
    let new: BTreeSet<_> = keys.filter(|key| !known.contains(key)).collect();
    let mut lines: String = new
        .iter()
        .map(|key| format!("{key} {}\n", sum(key)))
        .collect();
    let mut write = || -> io::Result<()> {
        let mut options = OpenOptions::new();
        let mut file = options.read(true).append(true).create(true).open(path)?;
        // After a line that was cut short, the next begins anew.
        if file.seek(SeekFrom::End(0))? > 0 {
            file.seek(SeekFrom::End(-1))?;
            let mut last = [0];
            file.read_exact(&mut last)?;
            if last != [b'\n'] {
                lines.insert(0, '\n');
            }
        }
        file.write_all(lines.as_bytes())
    };
    write().map_err(|error| {
        let message = format!("the record {} cannot be written: {error}", path.display());
        let fault = Fault::new(Cause::File, message);
        fault
            .note("name a file in a folder that can be written to")
            .into()
    })
}

/// The record at `path`.
///
/// # Errors
/// A file that cannot be read.
pub fn read(path: &Path) -> Result<Record, Error> {
    let bytes = fs::read(path).map_err(|error| unreadable(path, &error))?;
    let mut record = Record::default();
    for (number, line) in (1..).zip(bytes.split(|byte| *byte == b'\n')) {
        let line = String::from_utf8_lossy(line);
        match line.rsplit_once(' ') {
            _ if line.is_empty() => {}
            Some((key, found)) if sum(key) == found => drop(record.keys.insert(key.to_owned())),
            _ => record.warnings.push(format!(
                "{}:{number}: the line is passed over, as it is no key with its checksum: a run was killed as it wrote it, or \
                 it was changed",
                path.display()
            )),
        }
    }
    Ok(record)
}

/// Eight hexadecimal digits.
fn sum(key: &str) -> String {
    blake3::hash(key.as_bytes()).to_hex()[..8].to_owned()
}

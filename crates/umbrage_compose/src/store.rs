//! A folder of results that took time, by the hash of all that they depend on.

use std::{
    fs, io,
    path::{Path, PathBuf},
};

use crate::{
    Cause, Error, Fault,
    whole::{sweep_beside, write_whole},
};

/// A folder of results that took time, each by the hash of all that it depends on; several programs may
/// use it at once, each for its own *kind* of results.
///
/// An entry is a header that names the kind, the hash of what follows, and what follows. It is written to a
/// temporary file beside its place and then renamed, so that another process sees it whole or not at all.
/// A damaged entry is dropped when it is read, and said.
#[derive(Debug)]
pub struct Store {
    dir: PathBuf,
    kind: Kind,
}

/// Kind of a [`Store`]'s entries.
#[derive(Clone, Copy, Debug)]
pub struct Kind {
    /// Beginning of an entry: the kind and the version of its format.
    pub header: &'static [u8; 16],
    /// How an entry's file name ends, without the dot.
    pub extension: &'static str,
}

/// Outcome of a look into a [`Store`].
#[derive(Debug)]
pub enum Look<T> {
    /// There is an entry, whole and readable.
    Found(T),
    /// There is none.
    Missing,
    /// An entry was damaged or foreign, and is gone; what to tell a person.
    Dropped(String),
}

impl Store {
    /// The store in the folder `dir`, which is made where it is missing.
    ///
    /// # Errors
    /// A folder that cannot be made or written to.
    pub fn open(dir: impl Into<PathBuf>, kind: Kind) -> Result<Self, Error> {
        let dir = dir.into();
        let unusable = |error: io::Error| {
            let message = format!(
                "the cache folder `{}` cannot be used: {error}",
                dir.display()
            );
            Fault::new(Cause::File, message).note("name a folder that can be made and written to")
        };
        fs::create_dir_all(&dir).map_err(unusable)?;
        // Whether it can be written to shows only when something is.
        tempfile::tempfile_in(&dir).map_err(unusable)?;
        sweep_beside(&dir.join("any"));
        Ok(Self { dir, kind })
    }

    /// The entry `name`, as `decode` reads its payload; what it cannot read (it says why, in a
    /// lowercase fragment) is dropped.
    pub fn look<T>(
        &self,
        name: &str,
        decode: impl FnOnce(&[u8]) -> Result<T, &'static str>,
    ) -> Look<T> {
        let path = self.path(name);
        let bytes = match fs::read(&path) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Look::Missing,
            Err(error) => return drop_entry(&path, &error.to_string()),
        };
        match self.payload(&bytes).and_then(decode) {
            Ok(found) => Look::Found(found),
            Err(reason) => drop_entry(&path, reason),
        }
    }

    /// Keeps `payload` as the entry `name`; a warning where that fails.
    pub fn keep(&self, name: &str, payload: &[u8]) -> Option<String> {
        let path = self.path(name);
        let hash = blake3::hash(payload);
        let bytes = [self.kind.header.as_slice(), hash.as_bytes(), payload].concat();
        let error = write_whole(&path, &bytes).err()?;
        Some(format!(
            "the cache entry `{}` cannot be written: {error}",
            path.display()
        ))
    }

    fn payload<'a>(&self, bytes: &'a [u8]) -> Result<&'a [u8], &'static str> {
        let rest = bytes
            .strip_prefix(self.kind.header)
            .ok_or("it is of another format")?;
        let (hash, payload) = rest.split_at_checked(32).ok_or("it is cut short")?;
        if blake3::hash(payload).as_bytes() != hash {
            return Err("its contents do not fit its hash");
        }
        Ok(payload)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.dir.join(format!("{name}.{}", self.kind.extension))
    }
}

fn drop_entry<T>(path: &Path, reason: &str) -> Look<T> {
    let gone = match fs::remove_file(path) {
        Ok(()) => "it is dropped and made anew".to_owned(),
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            "another process dropped it".to_owned()
        }
        Err(error) => format!("it cannot be dropped: {error}"),
    };
    Look::Dropped(format!(
        "the cache entry `{}` is no good ({reason}); {gone}",
        path.display()
    ))
}

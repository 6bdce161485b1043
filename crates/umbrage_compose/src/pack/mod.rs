//! Packs: permutations made ahead, in one file.
//!
//! A pack is a zip archive without compression, so that ordinary tools open it and a program reads just the parts that it
//! needs. `pack.json` says what it was made from, `index.json` lists its permutations, and every other file is named by the
//! hash of its contents, once however many permutations have it: the IR that wgpu takes (`ir/`), the reflection as JSON
//! (`reflection/`), and the shader in each language asked for.
//!
//! Permutations that were validated when the pack was made are not validated again when it is read: `pack.json` has the hash of the index,
//! the index those of all files, and both say for which version of naga and which target that holds. A pack that is cut
//! short or changed is refused; one of older sources gives the permutations whose own modules are unchanged.

mod index;
mod write;

use std::{
    collections::HashMap,
    fs::File,
    io::{BufReader, Read as _},
    path::{Path, PathBuf},
    sync::{Mutex, OnceLock, PoisonError},
};

use zip::ZipArchive;

use self::index::{FORMAT, Head, Index, short};
pub use self::{
    index::{Header, Row},
    write::{Filled, PackWriter},
};
use crate::{
    Cause, Error, Fault, Library, Pass, Permutation, ProjectedKey, Target, cache, library::Request,
};

/// The files whose names are no hashes.
const HEAD: &str = "pack.json";
const INDEX: &str = "index.json";
/// Names of outputs in an index.
const IR: &str = "ir";
const REFLECTION: &str = "reflection";

/// A pack, opened to be read. Its files are read as they are needed.
#[derive(Debug)]
pub struct Pack {
    path: PathBuf,
    head: Head,
    archive: Mutex<ZipArchive<BufReader<File>>>,
    index: OnceLock<Result<Known, Error>>,
}

/// The index, with its permutations by identity and by root.
#[derive(Debug)]
struct Known {
    index: Index,
    by_identity: HashMap<String, usize>,
    by_root: HashMap<usize, Vec<usize>>,
}

impl Pack {
    /// The pack at `path`.
    ///
    /// # Errors
    /// A file that cannot be read, or that is no whole pack of this version.
    pub fn open(path: impl Into<PathBuf>) -> Result<Self, Error> {
        let path = path.into();
        let file = File::open(&path).map_err(|error| no_good(&path, &error.to_string()))?;
        let mut archive = ZipArchive::new(BufReader::new(file))
            .map_err(|error| no_good(&path, &format!("it is no whole zip archive: {error}")))?;
        let bytes = read(&mut archive, HEAD).map_err(|reason| no_good(&path, &reason))?;
        let head: Head = serde_json::from_slice(&bytes)
            .map_err(|error| no_good(&path, &format!("{HEAD} cannot be understood: {error}")))?;
        if head.header.format != FORMAT {
            let format = &head.header.format;
            let reason = format!("its format is `{format}`, not `{FORMAT}`");
            return Err(no_good(&path, &reason));
        }
        Ok(Self {
            path,
            head,
            archive: Mutex::new(archive),
            index: OnceLock::new(),
        })
    }

    /// Its place.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Its sources, selection and languages, by their hashes and names.
    pub fn header(&self) -> &Header {
        &self.head.header
    }

    /// Whether its index fits its hash, and all files that the index names are there, as far as can be told without reading
    /// them.
    pub fn is_whole(&self) -> bool {
        let mut archive = self.archive.lock().unwrap_or_else(PoisonError::into_inner);
        let index = read(&mut archive, INDEX).map(|bytes| short(&bytes) == self.head.index);
        index.unwrap_or(false) && archive.len() == self.head.files
    }

    /// How many permutations it has.
    pub fn len(&self) -> usize {
        self.head.permutations
    }

    /// Whether it has none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Its permutations, sorted by key.
    ///
    /// # Errors
    /// An index that does not fit its hash.
    pub fn rows(&self) -> Result<&[Row], Error> {
        Ok(&self.known()?.index.permutations)
    }

    /// The contents of a file that a row names.
    ///
    /// # Errors
    /// A file that is not there, or that does not fit its name.
    pub fn file(&self, name: &str) -> Result<Vec<u8>, Error> {
        let mut archive = self.archive.lock().unwrap_or_else(PoisonError::into_inner);
        let bytes = read(&mut archive, name).map_err(|reason| no_good(&self.path, &reason))?;
        let stem = name.rsplit('/').next().unwrap_or(name);
        let stem = stem.split('.').next().unwrap_or(stem);
        if short(&bytes) != stem {
            let reason = format!("the contents of {name} do not fit its name");
            return Err(no_good(&self.path, &reason));
        }
        Ok(bytes)
    }

    fn known(&self) -> Result<&Known, Error> {
        let known = self.index.get_or_init(|| {
            let mut archive = self.archive.lock().unwrap_or_else(PoisonError::into_inner);
            let no_good = |reason: String| no_good(&self.path, &reason);
            let bytes = read(&mut archive, INDEX).map_err(no_good)?;
            if short(&bytes) != self.head.index {
                return Err(no_good(format!("{INDEX} does not fit the hash in {HEAD}")));
            }
            let index: Index = serde_json::from_slice(&bytes)
                .map_err(|error| no_good(format!("{INDEX} cannot be understood: {error}")))?;
            Ok(Known::new(index))
        });
        known.as_ref().map_err(Clone::clone)
    }

    /// The key, and the permutation's identity, of a key with these demands on the linker, by the answers alone: only of a
    /// pack that is of the same library and target.
    pub(crate) fn find(
        &self,
        (library, target): (&Library, &Target),
        request: &Request,
    ) -> Result<Option<(ProjectedKey, &str)>, Error> {
        if !self.head.header.is_of(library, target) {
            return Ok(None);
        }
        let known = self.known()?;
        let counting = index::counting(request);
        let rows = known.by_root.get(&request.root).into_iter().flatten();
        let mut rows = rows.map(|row| &known.index.permutations[*row]);
        let Some(row) = rows.find(|row| row.asks.meets(request, &counting)) else {
            return Ok(None);
        };
        let key = ProjectedKey::of(library.parse_key(&row.key)?);
        Ok(Some((key, &row.identity)))
    }

    /// The permutation with this identity.
    pub(crate) fn by_identity(
        &self,
        identity: &str,
        keys: (&[ProjectedKey], Option<Pass>),
        target: &Target,
    ) -> Result<Option<Permutation>, Error> {
        if !self.head.header.is_usable(target) {
            return Ok(None);
        }
        let known = self.known()?;
        let Some(row) = known.by_identity.get(identity) else {
            return Ok(None);
        };
        let row = &known.index.permutations[*row];
        let lacking = || no_good(&self.path, &format!("`{}` has no IR", row.key));
        let bytes = self.file(row.files.get(IR).ok_or_else(lacking)?)?;
        // It was validated when the pack was made, and its hash is that of the index.
        cache::decode(&bytes, keys, target, true)
            .map(Some)
            .map_err(|reason| no_good(&self.path, &format!("`{}`: {reason}", row.key)))
    }
}

impl Known {
    fn new(index: Index) -> Self {
        let mut by_root: HashMap<_, Vec<_>> = HashMap::new();
        for (number, row) in index.permutations.iter().enumerate() {
            by_root.entry(row.asks.root).or_default().push(number);
        }
        let identities = index.permutations.iter().enumerate();
        let by_identity = identities.map(|(number, row)| (row.identity.clone(), number));
        Self {
            by_identity: by_identity.collect(),
            by_root,
            index,
        }
    }
}

/// A file of an archive, or why there is none.
fn read(archive: &mut ZipArchive<BufReader<File>>, name: &str) -> Result<Vec<u8>, String> {
    let mut file = archive
        .by_name(name)
        .map_err(|error| format!("{name} cannot be found: {error}"))?;
    // The size that the archive claims is no reason to take so much memory.
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes)
        .map_err(|error| format!("{name} cannot be read: {error}"))?;
    Ok(bytes)
}

fn no_good(path: &Path, reason: &str) -> Error {
    let message = format!("the pack {} cannot be used: {reason}", path.display());
    let fault = Fault::new(Cause::File, message);
    fault.note("make it anew with `umbrage prebuild`").into()
}

//! Packs, written.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs::File,
    io::{self, BufWriter, Read as _, Seek as _, SeekFrom, Write as _},
    path::Path,
    sync::{
        Arc,
        atomic::{AtomicUsize, Ordering},
    },
    thread,
};

use zip::{CompressionMethod, DateTime, ZipWriter, write::SimpleFileOptions};

use super::{
    HEAD, INDEX, IR, Pack, REFLECTION,
    index::{Asks, Head, Header, Index, Row, counting, json, short},
};
use crate::{
    Cause, Composer, Error, Fault, Language, Permutation, Stage, Variant, cache::DiskCache,
    outputs::stage_name, whole::write_whole_by,
};

/// A pack that is being made. Outputs wait in a temporary file without a name, so that memory holds the index alone and
/// nothing is left where the process is killed; the pack takes its place whole, or not at all.
///
/// However its permutations are shared out between threads and [shards](Header::shard), the bytes are the same.
#[derive(Debug)]
pub struct PackWriter {
    header: Header,
    index: Index,
    /// Outputs by the names of their files.
    files: BTreeMap<String, Kept>,
    spool: File,
    length: u64,
}

/// An output that is to be written.
#[derive(Clone, Debug)]
enum Kept {
    /// In the spool: from where on, and how many bytes.
    Spooled(u64, u64),
    /// In an earlier pack.
    Packed(Arc<Pack>),
}

/// A permutation, ready to be added.
#[derive(Debug)]
struct Packed {
    row: Row,
    outputs: Outputs,
    warnings: Vec<String>,
}

/// Permutations that were added to a pack.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Filled {
    /// How many were composed; the others were taken from an earlier pack, or are of another shard.
    pub composed: usize,
    /// Warnings about them.
    pub warnings: BTreeSet<String>,
}

/// Permutations that wait at once for a place in a pack: memory holds no more of them.
const AT_ONCE: usize = 256;

#[derive(Debug)]
enum Outputs {
    Made(Vec<(String, Vec<u8>)>),
    Kept(Arc<Pack>),
}

impl PackWriter {
    /// The beginning of a pack of `composer`'s permutations.
    ///
    /// # Errors
    /// No room for temporary files.
    pub fn new(composer: &Composer, header: Header) -> Result<Self, Error> {
        let library = composer.library();
        let sources = (0..library.sources().len()).map(|module| {
            let source = library.source(module);
            (source.path.clone(), short(source.text.as_bytes()))
        });
        let mut features: Vec<_> = library.features().iter().collect();
        features.sort_by_key(|(_, number)| *number);
        let features = features.into_iter();
        let index = Index {
            sources: sources.collect(),
            features: features.map(|(name, _)| name.to_owned()).collect(),
            permutations: Vec::new(),
        };
        Self::with_index(header, index)
    }

    fn with_index(header: Header, index: Index) -> Result<Self, Error> {
        Ok(Self {
            header,
            index,
            files: BTreeMap::new(),
            spool: tempfile::tempfile().map_err(|error| unwritable("a temporary file", &error))?,
            length: 0,
        })
    }

    /// Adds the permutations of `variants`, made by so many threads, those of its shard alone; what the pack `before` has of
    /// the same sources is taken over. `told` hears how many were gone through, and how many of them were composed.
    ///
    /// # Errors
    /// Faults in modules, what the target does not allow, what cannot be said in one of the languages (but for overrides
    /// without defaults, and for GLSL), a disk that is full.
    pub fn fill<'c>(
        &mut self,
        composer: &'c Composer,
        mut variants: impl Iterator<Item = Variant<'c>>,
        threads: usize,
        before: Option<&Arc<Pack>>,
        mut told: impl FnMut(usize, usize),
    ) -> Result<Filled, Error> {
        let mut filled = Filled::default();
        let mut done = 0;
        loop {
            let some: Vec<_> = variants.by_ref().take(AT_ONCE).collect();
            if some.is_empty() {
                return Ok(filled);
            }
            done += some.len();
            let (next, header) = (AtomicUsize::new(0), &self.header);
            let work = || {
                let mut made = Vec::new();
                while let Some(variant) = some.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let place = variant.key().to_string();
                    made.push((place, Self::make(composer, header, variant, before)));
                }
                made
            };
            let mut made: Vec<_> = thread::scope(|scope| {
                let threads: Vec<_> = (0..threads.max(1)).map(|_| scope.spawn(work)).collect();
                let ended = threads.into_iter().map(|thread| {
                    let ended = thread.join();
                    ended.unwrap_or_else(|panic| std::panic::resume_unwind(panic))
                });
                ended.flatten().collect()
            });
            // Whichever thread was faster, the same fault is told.
            made.sort_by(|(a, _), (b, _)| a.cmp(b));
            for (_, packed) in made {
                let Some(packed) = packed? else {
                    continue;
                };
                filled.composed += usize::from(matches!(packed.outputs, Outputs::Made(_)));
                filled.warnings.extend(packed.warnings.iter().cloned());
                self.add(packed)?;
            }
            told(done, filled.composed);
        }
    }

    /// The permutation of `variant`, made for a pack with this header: taken from the pack `before`, where it has the same;
    /// none where it is of another shard.
    fn make(
        composer: &Composer,
        header: &Header,
        variant: &Variant<'_>,
        before: Option<&Arc<Pack>>,
    ) -> Result<Option<Packed>, Error> {
        if let Some(fault) = variant.fault() {
            return Err(fault);
        }
        let key = variant.key();
        let identity = composer.identity(variant);
        if let Some([own, of]) = header.shard {
            let digits = u32::from_str_radix(&identity[..8], 16).unwrap_or(0);
            if digits % of != own - 1 {
                return Ok(None);
            }
        }
        let before = before.filter(|pack| pack.header().is_alike(header));
        let known = match before {
            Some(pack) => {
                let known = pack.known()?;
                let row = known.by_identity.get(&identity);
                row.map(|row| (pack, &known.index.permutations[*row]))
            }
            None => None,
        };
        let place = |row: &mut Row| {
            row.modules = variant.module_numbers().iter().collect();
            row.asks = asks(variant);
        };
        if let Some((pack, row)) = known {
            let mut row = row.clone();
            place(&mut row);
            return Ok(Some(Packed {
                row,
                outputs: Outputs::Kept(Arc::clone(pack)),
                warnings: Vec::new(),
            }));
        }
        let permutation = composer.make_alone(variant)?;
        let mut row = Row {
            key: key.to_string(),
            identity,
            modules: Vec::new(),
            asks: Asks::default(),
            files: BTreeMap::new(),
            overrides: (permutation.reflection.overrides.iter())
                .map(|item| item.name.clone())
                .collect(),
            lacks: BTreeMap::new(),
        };
        place(&mut row);
        let outputs = outputs(&permutation, &header.languages, &mut row)?;
        Ok(Some(Packed {
            row,
            outputs: Outputs::Made(outputs),
            warnings: permutation.warnings.clone(),
        }))
    }

    fn add(&mut self, packed: Packed) -> Result<(), Error> {
        match packed.outputs {
            Outputs::Made(outputs) => {
                for (name, bytes) in outputs {
                    let length = bytes.len() as u64;
                    let kept = Kept::Spooled(self.length, length);
                    if self.files.contains_key(&name) {
                        continue;
                    }
                    self.spool
                        .write_all(&bytes)
                        .map_err(|error| unwritable("a temporary file", &error))?;
                    self.length += length;
                    self.files.insert(name, kept);
                }
            }
            Outputs::Kept(pack) => {
                for name in packed.row.files.values() {
                    let kept = || Kept::Packed(Arc::clone(&pack));
                    self.files.entry(name.clone()).or_insert_with(kept);
                }
            }
        }
        self.index.permutations.push(packed.row);
        Ok(())
    }

    /// Writes the pack to `path`, in the place of what is there, and tells how many permutations it has.
    ///
    /// # Errors
    /// No permutation, a folder that cannot be written to, and an earlier pack that turns out to be damaged.
    pub fn finish(mut self, path: &Path) -> Result<usize, Error> {
        let rows = &mut self.index.permutations;
        rows.sort_by(|a, b| a.key.cmp(&b.key));
        rows.dedup_by(|a, b| a.key == b.key);
        let count = rows.len();
        if count == 0 && self.header.shard.is_none() {
            let fault = Fault::new(Cause::Key, "there is no permutation to put into a pack");
            return Err(fault.note("select keys that are legal").into());
        }
        let index = json(&self.index)?;
        let head = Head {
            header: self.header,
            permutations: count,
            files: self.files.len() + 2,
            index: short(&index),
        };
        let head = json(&head)?;
        let mut failed = None;
        let written = write_whole_by(path, |file| {
            let mut zip = ZipWriter::new(BufWriter::new(file));
            let options = SimpleFileOptions::default()
                .compression_method(CompressionMethod::Stored)
                .last_modified_time(DateTime::default())
                .unix_permissions(0o644);
            for (name, bytes) in [(HEAD, &head), (INDEX, &index)] {
                zip.start_file(name, options)?;
                zip.write_all(bytes)?;
            }
            for (name, kept) in &self.files {
                let bytes = match kept {
                    Kept::Spooled(start, length) => {
                        self.spool.seek(SeekFrom::Start(*start))?;
                        let mut bytes = Vec::new();
                        (&mut self.spool).take(*length).read_to_end(&mut bytes)?;
                        bytes
                    }
                    Kept::Packed(pack) => match pack.file(name) {
                        Ok(bytes) => bytes,
                        Err(error) => {
                            failed = Some(error);
                            return Err(io::Error::other("an earlier pack is damaged"));
                        }
                    },
                };
                zip.start_file(name.as_str(), options)?;
                zip.write_all(&bytes)?;
            }
            zip.finish()?.flush()
        });
        match (written, failed) {
            (Ok(()), _) => Ok(count),
            (Err(_), Some(error)) => Err(error),
            (Err(error), None) => Err(unwritable(&path.display().to_string(), &error)),
        }
    }

    /// The pack of all of `shards`, as if it had been made at once.
    ///
    /// # Errors
    /// No shard, shards of different packs, one twice, or one missing.
    pub fn merge(shards: &[Arc<Pack>]) -> Result<Self, Error> {
        let fault =
            |message: String, note: &str| Error::from(Fault::new(Cause::File, message).note(note));
        let Some(first) = shards.first() else {
            return Err(fault(
                "there is no pack to merge".to_owned(),
                "name the shards",
            ));
        };
        let whole = Header {
            shard: None,
            ..first.header().clone()
        };
        let mut places = BTreeMap::new();
        let mut of = 0;
        for pack in shards {
            let header = pack.header();
            let Some([own, count]) = header.shard else {
                let message = format!("{} is no shard, but a whole pack", pack.path().display());
                return Err(fault(message, "merge what `prebuild --shard` made"));
            };
            let alike = Header {
                shard: None,
                ..header.clone()
            };
            if alike != whole || (of != 0 && of != count) {
                let message = format!(
                    "{} and {} are shards of different packs: made from other sources or keys, for another target, in other \
                     languages, or shared out by another number",
                    first.path().display(),
                    pack.path().display()
                );
                return Err(fault(message, "make all shards from the same state"));
            }
            of = count;
            if let Some(other) = places.insert(own, pack) {
                let message = format!(
                    "{} and {} are the same shard, {own} of {count}",
                    other.path().display(),
                    pack.path().display()
                );
                return Err(fault(message, "name each shard once"));
            }
        }
        let missing = (1..=of).filter(|own| !places.contains_key(own));
        let missing: Vec<_> = missing.map(|own| own.to_string()).collect();
        if !missing.is_empty() {
            let message = format!("no shard {} of {of}", missing.join(", "));
            return Err(fault(message, "name all shards"));
        }
        let known = first.known()?;
        let index = Index {
            permutations: Vec::new(),
            ..known.index.clone()
        };
        let mut merged = Self::with_index(whole, index)?;
        for pack in places.values() {
            for row in pack.rows()? {
                merged.add(Packed {
                    row: row.clone(),
                    outputs: Outputs::Kept(Arc::clone(pack)),
                    warnings: Vec::new(),
                })?;
            }
        }
        Ok(merged)
    }
}

/// Answers of a permutation's keys to what the linking asks.
fn asks(variant: &Variant<'_>) -> Asks {
    let request = variant.request();
    let mut asks = Asks {
        root: request.root,
        counting: counting(&request),
        ..Asks::default()
    };
    let (mut features, mut interfaces) = (BTreeSet::new(), BTreeSet::new());
    for (_, entry) in variant.entries() {
        if let Ok(prepared) = &entry.prepared {
            features.extend(prepared.consulted.asked.iter());
            interfaces.extend(prepared.interfaces.iter().copied());
        }
    }
    for feature in features {
        match request.features.contains(feature) {
            true => asks.on.push(feature),
            false => asks.off.push(feature),
        }
    }
    let bound = interfaces.into_iter();
    asks.bound = bound
        .map(|interface| (interface, request.bindings.get(&interface).copied()))
        .collect();
    asks
}

/// A permutation's files, which are noted in its row.
fn outputs(
    permutation: &Permutation,
    languages: &BTreeSet<Language>,
    row: &mut Row,
) -> Result<Vec<(String, Vec<u8>)>, Error> {
    let mut files = Vec::new();
    let mut keep =
        |row: &mut Row, output: String, folder: &str, extension: &str, bytes: Vec<u8>| {
            let name = format!("{folder}/{}.{extension}", short(&bytes));
            row.files.insert(output, name.clone());
            files.push((name, bytes));
        };
    let ir = DiskCache::encode(permutation)
        .map_err(|error| Fault::new(Cause::File, format!("the IR cannot be encoded: {error}")))?;
    keep(row, IR.to_owned(), IR, "bin", ir);
    let reflection = json(&permutation.reflection)?;
    keep(row, REFLECTION.to_owned(), REFLECTION, "json", reflection);
    let entries = &permutation.reflection.entry_points;
    let stage = |name: &str| {
        let entry = entries.iter().find(|entry| entry.name == name);
        stage_name(entry.map_or(Stage::Compute, |entry| entry.stage))
    };
    for language in languages {
        let folder = language.name();
        let written = match permutation.outputs(*language) {
            Ok(written) => written,
            Err(error) if may_lack(*language, permutation) => {
                row.lacks.insert(*language, first_line(&error));
                continue;
            }
            Err(error) => return Err(error),
        };
        for output in written {
            match &output.entry_point {
                None => {
                    let name = folder.to_owned();
                    keep(row, name, folder, language.extension(), output.bytes);
                }
                Some(entry) => {
                    let extension = format!("{}.{}", stage(entry), language.extension());
                    keep(
                        row,
                        format!("{folder} {entry}"),
                        folder,
                        &extension,
                        output.bytes,
                    );
                }
            }
        }
    }
    Ok(files)
}

/// Whether a permutation that cannot be said in a language is no fault: of one with overrides a host takes the WGSL and
/// sets them, and OpenGL ES has less than WebGPU.
fn may_lack(language: Language, permutation: &Permutation) -> bool {
    match language {
        Language::Wgsl => false,
        Language::Glsl => true,
        _ => !permutation.reflection.overrides.is_empty(),
    }
}

fn first_line(error: &Error) -> String {
    let faults = error.faults().iter().map(|fault| fault.message.clone());
    faults.collect::<Vec<_>>().join("; ")
}

fn unwritable(what: &str, error: &io::Error) -> Error {
    let fault = Fault::new(Cause::File, format!("{what} cannot be written: {error}"));
    fault
        .note("choose a folder that can be written to and has room")
        .into()
}

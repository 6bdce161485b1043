//! Packs and records that are damaged: refused or passed over, and never another shader.

use std::{
    collections::BTreeSet,
    fs,
    io::{Read as _, Write as _},
    path::Path,
    sync::Arc,
};

use proptest::prelude::*;
use umbrage_compose::{
    Composer, Error, Header, Key, Language, Library, Pack, PackWriter, Package, Selection, Source,
    Target, record,
};

const AXES: &str = r#"(axes: {
    "pass": (values: { "main": (root: "package::main"), "other": (root: "package::other") }),
    "tint": (default: "off", values: { "off": (), "on": (features: ["TINT"]) }),
    "unread": (default: "off", values: { "off": (), "on": (features: ["UNREAD"]) }),
})"#;
const MAIN: &str = "
import package::shared::{half, K};
@fragment fn main() -> @location(0) vec4f {
    @if(TINT) { return vec4f(half(K), 0.0, 0.0, 1.0); }
    return vec4f(half(1.0));
}
";
const OTHER: &str = "
@group(0) @binding(0) var<storage, read_write> numbers: array<u32>;
@compute @workgroup_size(64) fn other(@builtin(global_invocation_id) id: vec3u) { numbers[id.x] += 1u; }
";
const SHARED: &str = "const K = 0.25;\nfn half(x: f32) -> f32 { return 0.5 * x; }\n";

fn library(shared: &str) -> Library {
    let files = [
        ("axes.ron", AXES),
        ("main.wesl", MAIN),
        ("other.wesl", OTHER),
        ("shared.wesl", shared),
    ];
    let files = files.map(|(path, text)| (path.to_owned(), text.to_owned()));
    let package = Package::from_sources("small", "small", files).expect("a package");
    Library::new([package]).expect("a library")
}

fn composer(shared: &str) -> Composer {
    Composer::new(library(shared), Target::webgpu())
}

fn header(composer: &Composer, shard: Option<[u32; 2]>) -> Header {
    let all = BTreeSet::from(Language::ALL);
    let (library, target) = (composer.library(), composer.target());
    Header {
        shard,
        ..Header::new(library, target, all, Selection::all().hash())
    }
}

fn written(path: &Path, threads: usize, shard: Option<[u32; 2]>) -> Vec<u8> {
    let composer = composer(SHARED);
    let mut writer = PackWriter::new(&composer, header(&composer, shard)).expect("begun");
    let variants = composer.variants();
    let filled = writer.fill(&composer, variants, threads, None, |_, _| ());
    filled.expect("filled");
    writer.finish(path).expect("written");
    fs::read(path).expect("a pack")
}

fn keys(library: &Library) -> Vec<Key> {
    let passes = ["main", "other"];
    let choices = ["off", "on"];
    let mut all = Vec::new();
    for pass in passes {
        for tint in choices {
            for unread in choices {
                let key = [("pass", pass), ("tint", tint), ("unread", unread)];
                all.push(library.key(key).expect("a key"));
            }
        }
    }
    all
}

/// Holds a composer with the pack at `path` against one without, key by key; how many permutations came from the pack.
fn held(path: &Path, shared: &str) -> Result<usize, Error> {
    let pack = Arc::new(Pack::open(path)?);
    let (packed, own) = (composer(shared).with_pack(pack), composer(shared));
    let mut from_pack = 0;
    for key in keys(own.library()) {
        let (found, own) = (packed.compose(&key)?, own.compose(&key)?);
        from_pack += usize::from(found.source == Source::Pack);
        let is_told = found
            .warnings
            .iter()
            .any(|told| told.contains("small.pack"));
        assert!(is_told || found.source != Source::Linked, "{key}");
        let (found, own) = (&found.permutation, &own.permutation);
        assert_eq!(found.key, own.key);
        assert_eq!(found.reflection, own.reflection);
        assert_eq!(found.wgsl()?, own.wgsl()?);
        assert_eq!(found.spirv()?, own.spirv()?);
    }
    Ok(from_pack)
}

#[test]
fn a_pack_has_each_permutation_and_stands_for_all_keys() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("small.pack");
    let bytes = written(&path, 1, None);
    for threads in 1..5 {
        assert!(bytes == written(&path, threads, None), "{threads} threads");
    }
    assert_eq!(Pack::open(&path).expect("a pack").len(), 3);
    assert!(Pack::open(&path).expect("a pack").is_whole());
    // Three permutations; other keys that make the same one find it in memory.
    assert_eq!(held(&path, SHARED).expect("composes"), 3);
    // Of other sources, what does not read the module that differs.
    let edited = SHARED.replace("0.25", "0.75");
    assert!(held(&path, &edited).expect("composes") > 0);
}

#[test]
fn a_target_with_other_limits_takes_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("small.pack");
    written(&path, 1, None);
    let target = Target::webgpu().with_limit(umbrage_compose::Limit::ColorAttachments, 4);
    let pack = Arc::new(Pack::open(&path).expect("a pack"));
    let composer = Composer::new(library(SHARED), target).with_pack(pack);
    for key in keys(composer.library()) {
        assert_ne!(
            composer.compose(&key).expect("composes").source,
            Source::Pack
        );
    }
}

#[test]
fn shards_are_the_whole() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    let whole = written(&path("small.pack"), 1, None);
    for of in 1..6 {
        let shards = (1..=of).map(|own| {
            let path = path(&format!("{own}.pack"));
            written(&path, 2, Some([own, of]));
            Arc::new(Pack::open(path).expect("a pack"))
        });
        let shards: Vec<_> = shards.collect();
        let merged = PackWriter::merge(&shards).expect("merged");
        merged.finish(&path("merged.pack")).expect("written");
        assert!(
            fs::read(path("merged.pack")).expect("a pack") == whole,
            "{of}"
        );
    }
}

/// Another file under a name is found by its hash, though the archive itself is sound.
#[test]
fn files_that_changed_places_are_told_of() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("small.pack");
    let bytes = written(&path, 1, None);
    let mut archive = zip::ZipArchive::new(std::io::Cursor::new(bytes)).expect("an archive");
    let mut files = Vec::new();
    for place in 0..archive.len() {
        let mut file = archive.by_index(place).expect("a file");
        let mut contents = Vec::new();
        file.read_to_end(&mut contents).expect("read");
        files.push((file.name().to_owned(), contents));
    }
    let is_ir = |place: &usize| files[*place].0.starts_with("ir/");
    let places: Vec<_> = (0..files.len()).filter(is_ir).collect();
    let first = files[places[0]].1.clone();
    for pair in places.windows(2) {
        files[pair[0]].1 = files[pair[1]].1.clone();
    }
    files[places[places.len() - 1]].1 = first;
    let mut writer = zip::ZipWriter::new(fs::File::create(&path).expect("a file"));
    let options =
        zip::write::SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
    for (name, contents) in files {
        writer.start_file(name, options).expect("begun");
        writer.write_all(&contents).expect("written");
    }
    writer.finish().expect("ended");
    let pack = Pack::open(&path).expect("a sound archive");
    for row in pack.rows().expect("an index") {
        let told = pack
            .file(&row.files["ir"])
            .expect_err("another's")
            .to_string();
        assert!(told.contains("do not fit its name"), "{told}");
    }
    assert_eq!(held(&path, SHARED).expect("composes"), 0);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, ..ProptestConfig::default() })]

    /// A pack that is cut, or of which bytes are others, is refused, or gives what composing gives.
    #[test]
    fn a_damaged_pack_gives_no_other_shader(
        cut in prop::option::weighted(0.2, 0.0..1.0),
        flips in prop::collection::vec((0.0..1.0, 1u8..), 0..4),
    ) {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("small.pack");
        let mut bytes = written(&path, 1, None);
        for (place, by) in &flips {
            let place = (place * bytes.len() as f64) as usize;
            bytes[place] ^= by;
        }
        if let Some(cut) = cut {
            bytes.truncate((cut * bytes.len() as f64) as usize);
        }
        fs::write(&path, &bytes).expect("written");
        if let Err(error) = held(&path, SHARED) {
            let told = error.to_string();
            prop_assert!(told.contains("small.pack cannot be used"), "{told}");
        }
    }

    /// Runs that are killed as they write leave lines that are passed over, and no key that was none.
    #[test]
    fn a_record_that_is_cut_loses_no_more_than_its_end(cuts in prop::collection::vec(0usize..80, 1..5)) {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("run.record");
        let composer = composer(SHARED);
        let projected = keys(composer.library()).into_iter().map(|key| composer.project(&key).expect("projects"));
        let all: Vec<_> = projected.collect();
        let texts: BTreeSet<_> = all.iter().map(ToString::to_string).collect();
        for cut in cuts {
            record::append(&path, &all).expect("written");
            let bytes = fs::read(&path).expect("a record");
            fs::write(&path, &bytes[..bytes.len() - cut.min(bytes.len())]).expect("cut");
            prop_assert!(record::read(&path).expect("a record").keys.is_subset(&texts));
        }
        record::append(&path, &all).expect("written");
        prop_assert_eq!(record::read(&path).expect("a record").keys, texts);
    }
}

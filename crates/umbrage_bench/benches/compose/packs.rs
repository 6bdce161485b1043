//! Permutations made ahead: a pack over what naga takes to parse, validate and write them, packs made again, and a start
//! from a pack over one from nothing.

use std::{
    collections::{BTreeMap, BTreeSet},
    error::Error,
    fs,
    hint::black_box,
    path::Path,
    sync::Arc,
    thread,
    time::Instant,
};

use naga::{
    back::spv,
    valid::{Capabilities, ValidationFlags, Validator},
};
use serde::Serialize;
use umbrage_compose::{
    Composer, Header, Key, Language, Library, Pack, PackWriter, Package, Selection, Target,
};

/// Permutations of a pack.
const COUNT: usize = 10_000;
/// Permutations of which the floor is taken.
const SAMPLE: usize = 200;
/// Permutations that a program starts with.
const STARTED: usize = 50;

#[derive(Serialize)]
pub(crate) struct Packs {
    /// WGSL and SPIR-V of [`COUNT`] permutations on all cores, over naga parsing, validating and writing each one's text
    /// on as many.
    prebuild_over_floor: f64,
    unchanged_over_prebuild: f64,
    /// One module edited, over all made, and the share of the permutations that it reaches.
    edited_over_prebuild: f64,
    edited_share: f64,
    /// A library and [`STARTED`] permutations from a pack, over the same composed from cold.
    pack_over_cold: f64,
    /// Two shards on a core each, over all on one core.
    shards_over_one: f64,
    /// Of the pack.
    mib: f64,
    seconds: f64,
}

impl Packs {
    pub(crate) fn measure() -> Result<Self, Box<dyn Error>> {
        let cores = thread::available_parallelism().map_or(1, usize::from);
        let folder = tempfile::tempdir()?;
        let shaders = folder.path().join("shader_lib");
        copy(
            &Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shader_lib"),
            &shaders,
        )?;
        let out = folder.path().join("all.pack");
        let seconds = timed(|| make(&shaders, &out, (cores, None)))?;
        let pack = Pack::open(&out)?;
        let (floor, edit, edited_share) = survey(&shaders)?;
        let unchanged = timed(|| make(&shaders, &out, (cores, None)))?;
        let text = fs::read_to_string(&edit)?;
        fs::write(&edit, format!("{text}\n// edited\n"))?;
        let edited = timed(|| make(&shaders, &out, (cores, None)))?;
        fs::write(&edit, text)?;

        let single = folder.path().join("single.pack");
        let one = timed(|| make(&shaders, &single, (1, None)))?;
        let two = timed(|| {
            thread::scope(|scope| {
                let shards = [1, 2].map(|own| {
                    let out = folder.path().join(format!("{own}.pack"));
                    let shaders = &shaders;
                    scope.spawn(move || {
                        make(shaders, &out, (1, Some([own, 2]))).map_err(|error| error.to_string())
                    })
                });
                for shard in shards {
                    shard.join().map_err(|_| "a shard panicked")??;
                }
                Ok(())
            })
        })?;
        Ok(Self {
            prebuild_over_floor: seconds / (floor * COUNT as f64 / cores as f64),
            unchanged_over_prebuild: unchanged / seconds,
            edited_over_prebuild: edited / seconds,
            edited_share,
            pack_over_cold: start(&single, &shaders)?,
            shards_over_one: two / one,
            mib: fs::metadata(pack.path())?.len() as f64 / 1048576.0,
            seconds,
        })
    }

    pub(crate) fn print(&self) {
        println!(
            "(h) {COUNT} prebuilt over floor {:.3}  (goal 0.10), in {:.1} s and {:.0} MiB",
            self.prebuild_over_floor, self.seconds, self.mib
        );
        println!(
            "(i) unchanged over prebuilt {:.4}  (goal 0.01)",
            self.unchanged_over_prebuild
        );
        println!(
            "(j) edited over prebuilt    {:.3}  (goal 0.06), of which {:.1} % are reached",
            self.edited_over_prebuild,
            100.0 * self.edited_share
        );
        println!(
            "(k) pack over cold          {:.3}  (goal 0.1)",
            self.pack_over_cold
        );
        println!(
            "(l) two shards over one     {:.3}  (goal 0.55)",
            self.shards_over_one
        );
    }
}

fn timed(work: impl FnOnce() -> Result<(), Box<dyn Error>>) -> Result<f64, Box<dyn Error>> {
    let start = Instant::now();
    work()?;
    Ok(start.elapsed().as_secs_f64())
}

fn library(shaders: &Path) -> Result<Library, umbrage_compose::Error> {
    Library::new([Package::load("umbrage", shaders)?])
}

/// The first permutations of the space, as `umbrage prebuild` makes them.
fn make(
    shaders: &Path,
    out: &Path,
    (threads, shard): (usize, Option<[u32; 2]>),
) -> Result<(), Box<dyn Error>> {
    let composer = Composer::new(library(shaders)?, Target::webgpu());
    let languages = BTreeSet::from([Language::Wgsl, Language::Spirv]);
    let selected = format!("first {COUNT}");
    let mut header = Header::new(composer.library(), composer.target(), languages, selected);
    header.shard = shard;
    let before = Pack::open(out).ok().map(Arc::new);
    if let Some(pack) = &before
        && *pack.header() == header
        && pack.is_whole()
    {
        return Ok(());
    }
    let mut writer = PackWriter::new(&composer, header)?;
    let variants = composer.variants().take(COUNT);
    writer.fill(&composer, variants, threads, before.as_ref(), |_, _| ())?;
    writer.finish(out)?;
    Ok(())
}

/// Seconds that naga takes for one permutation's text; a module that some 5 in 100 permutations reach, and how many do.
fn survey(shaders: &Path) -> Result<(f64, std::path::PathBuf, f64), Box<dyn Error>> {
    let composer = Composer::new(library(shaders)?, Target::webgpu());
    let mut reached: BTreeMap<String, usize> = BTreeMap::new();
    let mut keys = Vec::new();
    for (number, variant) in composer.variants().take(COUNT).enumerate() {
        for module in variant.modules() {
            *reached.entry(module.to_owned()).or_default() += 1;
        }
        if number % (COUNT / SAMPLE) == 0 {
            keys.push(Key::from(variant.key()));
        }
    }
    let mut seconds = 0.0;
    for key in &keys {
        let text = composer.compose(key)?.permutation.wgsl()?;
        let start = Instant::now();
        let module = naga::front::wgsl::parse_str(&text)?;
        let info = Validator::new(ValidationFlags::all(), Capabilities::all()).validate(&module)?;
        black_box(spv::write_vec(
            &module,
            &info,
            &spv::Options::default(),
            None,
        )?);
        seconds += start.elapsed().as_secs_f64();
    }
    let share = |count: usize| count as f64 / COUNT as f64;
    let off = |count: usize| (share(count) - 0.05).abs();
    let nearest = reached
        .iter()
        .min_by(|a, b| off(*a.1).total_cmp(&off(*b.1)));
    let (module, count) = nearest.ok_or("no module is reached")?;
    let path = module.split("::").skip(1).collect::<Vec<_>>().join("/");
    let file = shaders.join(path).with_extension("wesl");
    Ok((seconds / keys.len() as f64, file, share(*count)))
}

/// The median over rounds of a start from the pack, over one from cold.
fn start(pack: &Path, shaders: &Path) -> Result<f64, Box<dyn Error>> {
    let rows = Pack::open(pack)?;
    let rows = rows.rows()?;
    let keys = rows.iter().step_by(rows.len() / STARTED).take(STARTED);
    let keys: Vec<_> = keys.map(|row| row.key.clone()).collect();
    // A pack of what the program starts with, and no more.
    let small = pack.with_extension("small.pack");
    let composer = Composer::new(library(shaders)?, Target::webgpu());
    let languages = BTreeSet::from([Language::Wgsl, Language::Spirv]);
    let header = Header::new(
        composer.library(),
        composer.target(),
        languages,
        "some".to_owned(),
    );
    let mut writer = PackWriter::new(&composer, header)?;
    let parsed = keys.iter().map(|key| composer.library().parse_key(key));
    let parsed = parsed.collect::<Result<Vec<_>, _>>()?;
    let selection = Selection::of(composer.library(), &parsed);
    writer.fill(&composer, composer.select(&selection), 1, None, |_, _| ())?;
    writer.finish(&small)?;
    let compose = |pack: Option<&Path>| {
        timed(|| {
            let mut composer = Composer::new(library(shaders)?, Target::webgpu());
            if let Some(pack) = pack {
                composer = composer.with_pack(Arc::new(Pack::open(pack)?));
            }
            for key in &keys {
                black_box(composer.compose(&composer.library().parse_key(key)?)?);
            }
            Ok(())
        })
    };
    let mut ratios = Vec::new();
    for _ in 0..21 {
        ratios.push(compose(Some(&small))? / compose(None)?);
    }
    ratios.sort_by(f64::total_cmp);
    Ok(ratios[ratios.len() / 2])
}

fn copy(from: &Path, to: &Path) -> Result<(), Box<dyn Error>> {
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from)? {
        let entry = entry?;
        let place = to.join(entry.file_name());
        match entry.file_type()?.is_dir() {
            true => copy(&entry.path(), &place)?,
            false => drop(fs::copy(entry.path(), place)?),
        }
    }
    Ok(())
}

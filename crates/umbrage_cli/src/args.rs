//! The command's arguments.

use std::path::PathBuf;

use clap::{
    Args, Parser, Subcommand, ValueEnum,
    builder::{PossibleValuesParser, TypedValueParser},
};
use umbrage::compose::Language;
use umbrage::compose::Lint;
use umbrage::render::{Path, Scene, SceneError, Staging};

/// Composes shader permutations, and renders scenes with shadow methods.
///
/// Exit status: 0 done, 1 what was checked was found wanting (check, cost, stress), 2 unusable arguments or input, 130
/// interrupted.
#[derive(Parser)]
#[command(name = "umbrage", version)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Subcommand)]
pub(crate) enum Command {
    /// Renders a scene to a picture.
    Render(RenderArgs),
    /// Finds a scene's shadow term by rays: what every shadow method is to come near to.
    Truth(TruthArgs),
    /// Measures shadow methods against the truth, and what they cost, and writes a report.
    Compare(CompareArgs),
    /// Tries shadow methods on the hard cases; status 1 where one misses a limit.
    Stress(StressArgs),
    /// Validates every permutation of packages, or of manifests.
    ///
    /// Exit status: 0 all is well, 1 faults or denied lints were found or a cost is over its budget, 2 the check could not be carried out.
    Check(CheckArgs),
    /// Says how many permutations packages or a manifest have, and which axes make them.
    List(ListArgs),
    /// Says what a key's permutation is made of and why, or which permutations an edit of a module's file touches.
    Explain(ExplainArgs),
    /// Makes every permutation of the manifests ahead, as a pack that an engine loads.
    Prebuild(PrebuildArgs),
    /// Makes one pack of the shards that `prebuild --shard` made.
    Merge(MergeArgs),
    /// Says which permutations of recorded runs a manifest lacks, and which of its own no run used.
    Cover(CoverArgs),
    /// Says what a GPU's compiler makes of every permutation, without a GPU.
    Cost(CostArgs),
    /// Links one module and prints it as WGSL.
    Link(LinkArgs),
    /// Says which adapter scenes are rendered with; status 2 where there is none.
    Adapter,
}

#[derive(Args)]
pub(crate) struct RenderArgs {
    /// A scene file (.ron), or a bare model (.glb, .gltf), which gets a ground, and a camera and a sun where it has none.
    pub(crate) scene: PathBuf,
    /// The picture's size in pixels.
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = size)]
    pub(crate) size: (u32, u32),
    #[command(flatten)]
    pub(crate) staging: StagingArgs,
    /// The light, counted from 0: the picture as if it were the only one; without it, all lights.
    #[arg(long, value_name = "N")]
    pub(crate) light: Option<usize>,
    /// The shadow method of all lights that cast shadows, in place of the scene's. Those with a `shadow` do; in a scene
    /// where none has one, all.
    #[arg(long, value_name = "NAME")]
    pub(crate) method: Option<String>,
    /// A value of an axis of the shader library, such as filter=hpsm, in place of the scene's; may be repeated.
    #[arg(long = "axis", value_name = "AXIS=VALUE", value_parser = choice)]
    pub(crate) axes: Vec<(String, String)>,
    /// A value of a setting of the lights' methods, such as resolution=512, in place of the scene's; may be repeated.
    #[arg(long = "setting", value_name = "NAME=NUMBER", value_parser = setting)]
    pub(crate) settings: Vec<(String, f64)>,
    /// What the picture shows.
    #[arg(long, value_enum, default_value_t)]
    pub(crate) what: What,
    /// How shadow terms come to where light is added, by each object's own shader or by a pass over the picture into a
    /// mask, one for all or one for each split: the picture is the same.
    #[arg(long, value_parser = path(), default_value_t)]
    pub(crate) path: Path,
    /// Steps along each ray through the scene's medium, where it has one.
    #[arg(long, value_name = "N", default_value_t = umbrage::render::RenderOptions::default().shaft_steps)]
    pub(crate) shaft_steps: u32,
    /// The picture to write.
    #[arg(long, value_name = "FILE.png")]
    pub(crate) out: PathBuf,
    /// A folder to keep permutations in from run to run; without it, none is kept.
    #[arg(long, value_name = "DIR")]
    pub(crate) cache: Option<PathBuf>,
    /// A pack of permutations that were made ahead: what it has is not composed.
    #[arg(long, value_name = "FILE.pack")]
    pub(crate) pack: Option<PathBuf>,
    /// A file to add the keys of all permutations to that the picture needs, for `umbrage cover`.
    #[arg(long, value_name = "FILE")]
    pub(crate) record: Option<PathBuf>,
    /// Prints the result as JSON on standard output.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args)]
pub(crate) struct TruthArgs {
    /// A scene file (.ron), or a bare model (.glb, .gltf), which gets a ground, and a camera and a sun where it has none.
    pub(crate) scene: PathBuf,
    /// The picture's size in pixels.
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = size)]
    pub(crate) size: (u32, u32),
    #[command(flatten)]
    pub(crate) staging: StagingArgs,
    /// The light, counted from 0; without it, the product over all lights that cast shadows. Those with a `shadow` do; in
    /// a scene where none has one, all. The term of a light that casts none is 1.
    #[arg(long, value_name = "N")]
    pub(crate) light: Option<usize>,
    /// Takes each light for one with an extent: a sphere's radius in metres, or for a directional light the
    /// angle from its disc's middle to its edge in degrees (the sun: 0.27); without it, a point.
    #[arg(long, value_name = "SIZE")]
    pub(crate) light_size: Option<f64>,
    /// Rays to a light with an extent: so many by so many a pixel.
    #[arg(long, value_name = "N", default_value_t = 8, requires = "light_size")]
    pub(crate) rays: u32,
    /// A folder to keep what was traced in from run to run; without it, nothing is kept.
    #[arg(long, value_name = "DIR")]
    pub(crate) cache: Option<PathBuf>,
    /// The picture to write: white is lit, black is in shadow.
    #[arg(long, value_name = "FILE.png")]
    pub(crate) out: PathBuf,
    /// Prints the camera, the lights and the cost as JSON on standard output.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args)]
pub(crate) struct CompareArgs {
    /// Scene files (.ron), or bare models (.glb, .gltf), which get a ground, and a camera and a sun where they have none.
    #[arg(required = true, value_name = "SCENE")]
    pub(crate) scenes: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) staging: StagingArgs,
    /// The methods, with commas between; without it or with `all`, every one.
    #[arg(long, value_name = "all|A,B")]
    pub(crate) methods: Option<String>,
    /// Lists of configurations to try; `standard` is the project's own, which is tried without any.
    #[arg(long, value_name = "FILE.ron", num_args = 1..)]
    pub(crate) configs: Vec<PathBuf>,
    /// The pictures' size in pixels.
    #[arg(long, value_name = "WxH", default_value = "640x360", value_parser = size)]
    pub(crate) size: (u32, u32),
    /// The folder to write report.html and report.json to: new, empty, or an earlier report, which is
    /// replaced as a whole.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// How many pairs of pictures, one of the plainest shadow map and one of its own, each configuration is timed by at the most;
    /// where their ratio is known well before, there are fewer.
    #[arg(long, value_name = "N", default_value_t = 40, value_parser = clap::value_parser!(u32).range(7..))]
    pub(crate) pairs: u32,
    /// Frames of a small motion in which shimmer is looked for; 0 looks for none.
    #[arg(long, value_name = "N", default_value_t = 8)]
    pub(crate) frames: u32,
    /// The GPU family that shaders are compiled for to tell their cost.
    #[arg(long, value_name = "NAME", default_value = umbrage_isa::CompilerOptions::FAMILY)]
    pub(crate) family: String,
    /// A folder to keep permutations and truths in from run to run; without it, none is kept.
    #[arg(long, value_name = "DIR")]
    pub(crate) cache: Option<PathBuf>,
}

/// The ground and sun that bare models get.
#[derive(Args)]
pub(crate) struct StagingArgs {
    /// Puts no ground under bare models.
    #[arg(long)]
    no_ground: bool,
    /// Puts no sun over bare models.
    #[arg(long)]
    no_sun: bool,
}

impl StagingArgs {
    /// Loads the scene at `path`, and tells on standard error what its models say and it does not show.
    pub(crate) fn load(&self, path: &std::path::Path) -> Result<Scene, SceneError> {
        let staging = Staging {
            ground: !self.no_ground,
            sun: !self.no_sun,
        };
        let scene = Scene::load_with(path, staging)?;
        for left_out in &scene.left_out {
            eprintln!("left out: {left_out}");
        }
        Ok(scene)
    }
}

#[derive(Args)]
pub(crate) struct StressArgs {
    /// The methods, with commas between; without it or with `all`, every one.
    #[arg(long, value_name = "all|A,B")]
    pub(crate) methods: Option<String>,
    /// The variants of these methods, with commas between; without it, every one.
    #[arg(long, value_name = "A,B")]
    pub(crate) variants: Option<String>,
    /// The hard cases, with commas between; without it, every one.
    #[arg(long, value_name = "A,B")]
    pub(crate) cases: Option<String>,
    /// The variants and the limits that they are held to; without it, the project's own.
    #[arg(long, value_name = "FILE.ron")]
    pub(crate) limits: Option<PathBuf>,
    /// A folder to keep permutations and truths in from run to run; without it, none is kept.
    #[arg(long, value_name = "DIR")]
    pub(crate) cache: Option<PathBuf>,
    /// A folder to write pictures of each case to: the method, the truth, the difference.
    #[arg(long, value_name = "DIR")]
    pub(crate) pictures: Option<PathBuf>,
    /// Prints the result as JSON on standard output.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Clone, Copy, Default, ValueEnum)]
pub(crate) enum What {
    /// The lit scene.
    #[default]
    Shaded,
    /// The bare shadow term: white is lit, black is in shadow.
    ShadowTerm,
    /// Which triangle each pixel sees: each in a colour of its own.
    Triangles,
    /// The texture fetches of the shadow term: white where they are most, black where there are none.
    Fetches,
    /// How the shadow term was found, in false colours: red by filtering, yellow as lit at once, blue as shadowed.
    Decisions,
    /// The texture fetches of the light that the air scatters: white where they are most, black where there are none.
    ShaftFetches,
    /// The lit scene, with a hue for each of the shadow maps that a light's splits have.
    Splits,
}

/// Permutations that no manifest selects.
#[derive(Args)]
pub(crate) struct KeyArgs {
    /// A key, as faults print it, such as light=spot,pass=shadow_term; may be repeated.
    #[arg(long = "key", value_name = "KEY")]
    pub(crate) keys: Vec<String>,
    /// A package's folder; without any, Umbrage's own shaders. Packages that it names in its wesl.toml come with it.
    #[arg(long = "package", value_name = "DIR", num_args = 1..)]
    pub(crate) packages: Vec<PathBuf>,
}

#[derive(Args)]
pub(crate) struct CheckArgs {
    /// The manifests; without any, the keys, and without these every permutation of the packages.
    #[arg(value_name = "MANIFEST", conflicts_with_all = ["keys", "packages"])]
    pub(crate) manifests: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) keys: KeyArgs,
    /// The target to validate for, in place of the manifests' own: webgpu, vulkan, metal, dx12, gles, a table of your
    /// own, or `this`, which is what this machine's adapter offers.
    #[arg(long, value_name = "NAME|FILE.ron")]
    pub(crate) target: Option<String>,
    /// A lint whose findings are errors; may be repeated. Without it they are warnings.
    #[arg(long = "deny", value_name = "LINT", value_parser = lint())]
    pub(crate) denied: Vec<Lint>,
    /// A lint whose findings are not told; may be repeated.
    #[arg(long = "allow", value_name = "LINT", value_parser = lint())]
    pub(crate) allowed: Vec<Lint>,
    /// Limits for what permutations cost on a GPU, as `cost` takes them: one over a limit is a fault. Every permutation
    /// that the manifests or keys select is compiled, so it asks for either.
    #[arg(long, value_name = "FILE.ron")]
    pub(crate) budget: Option<PathBuf>,
    /// The form in which the result is printed on standard output.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    /// Short for `--format json`.
    #[arg(long, conflicts_with = "format")]
    json: bool,
}

impl CheckArgs {
    pub(crate) fn format(&self) -> Format {
        match self.json {
            true => Format::Json,
            false => self.format,
        }
    }
}

/// Forms of a check's result. A person is told on standard error whichever it is.
#[derive(Clone, Copy, Default, ValueEnum)]
pub(crate) enum Format {
    /// Nothing on standard output: for a person.
    #[default]
    Text,
    /// All that was found, as JSON.
    Json,
    /// Annotations of GitHub's workflows, a line each.
    Github,
    /// SARIF 2.1.0, for services that show findings beside the code.
    Sarif,
    /// JUnit's XML, for services that show tests.
    Junit,
}

#[derive(Args)]
pub(crate) struct ListArgs {
    /// The manifest; without one, the keys, and without these every permutation of the packages.
    #[arg(conflicts_with_all = ["keys", "packages"])]
    pub(crate) manifest: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) keys: KeyArgs,
    /// Prints the result as JSON on standard output.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args)]
pub(crate) struct ExplainArgs {
    /// A key, such as light=spot,pass=shadow_term, or a module's file (.wesl).
    #[arg(value_name = "KEY|FILE")]
    pub(crate) what: String,
    /// A package's folder; without any, Umbrage's own shaders. Packages that it names in its wesl.toml come with it.
    #[arg(long = "package", value_name = "DIR", num_args = 1..)]
    pub(crate) packages: Vec<PathBuf>,
    /// Prints the result as JSON on standard output.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args)]
pub(crate) struct PrebuildArgs {
    /// The manifests; without any, the keys.
    #[arg(required_unless_present = "keys", value_name = "MANIFEST", conflicts_with_all = ["keys", "packages"])]
    pub(crate) manifests: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) keys: KeyArgs,
    /// The pack to write. Of an earlier one, what is still of the same sources is kept.
    #[arg(long, value_name = "FILE.pack")]
    pub(crate) out: PathBuf,
    /// The languages, with commas between, beside the IR that wgpu takes: wgsl, spirv, msl, hlsl, glsl.
    #[arg(long, value_name = "A,B", value_delimiter = ',', default_value = "wgsl,spirv", value_parser = language())]
    pub(crate) targets: Vec<Language>,
    /// Threads; without it, one a core.
    #[arg(long, value_name = "N")]
    pub(crate) jobs: Option<std::num::NonZeroUsize>,
    /// Makes the I-th of N parts alone, such as 1/2, for `umbrage merge`.
    #[arg(long, value_name = "I/N", value_parser = shard)]
    pub(crate) shard: Option<[u32; 2]>,
    /// Prints the result as JSON on standard output.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args)]
pub(crate) struct MergeArgs {
    /// All shards, in any order.
    #[arg(required = true, value_name = "FILE.pack")]
    pub(crate) shards: Vec<PathBuf>,
    /// The pack to write.
    #[arg(long, value_name = "FILE.pack")]
    pub(crate) out: PathBuf,
}

#[derive(Args)]
pub(crate) struct CoverArgs {
    /// Records of runs, as `umbrage render --record` writes them, and a manifest (.ron) as the last.
    #[arg(required = true, num_args = 2.., value_names = ["RECORD", "MANIFEST"])]
    pub(crate) files: Vec<PathBuf>,
    /// Prints the result as JSON on standard output.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args)]
pub(crate) struct CostArgs {
    /// The manifest; without one, the keys.
    #[arg(required_unless_present = "keys", conflicts_with_all = ["keys", "packages"])]
    pub(crate) manifest: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) keys: KeyArgs,
    /// The GPU family to compile for, by Mesa's name; without it the budget's, or else navi21.
    #[arg(long)]
    pub(crate) family: Option<String>,
    /// Limits for the figures: status 1 where a permutation is over one.
    #[arg(long, value_name = "FILE.ron")]
    pub(crate) budget: Option<PathBuf>,
    /// Prints the result as JSON on standard output.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args)]
pub(crate) struct LinkArgs {
    /// The module: all that it declares, and all that this reaches, is printed.
    #[arg(required_unless_present = "key")]
    pub(crate) file: Option<PathBuf>,
    /// A key, as faults print it, whose permutation is printed in place of a module.
    #[arg(long, value_name = "KEY", conflicts_with_all = ["file", "features", "bindings"])]
    pub(crate) key: Option<String>,
    /// The folder that `package::` stands for; by default the nearest above the file with a wesl.toml,
    /// or else the file's own. Of a key, the package's folder; by default Umbrage's own shaders.
    #[arg(long, value_name = "DIR")]
    pub(crate) package: Option<PathBuf>,
    /// A feature that is on; may be given again.
    #[arg(long = "feature", value_name = "NAME")]
    pub(crate) features: Vec<String>,
    /// The module that implements an interface; may be given again.
    #[arg(long = "bind", value_name = "INTERFACE=MODULE", value_parser = binding)]
    pub(crate) bindings: Vec<(String, String)>,
}

/// Languages by name.
fn language() -> impl TypedValueParser<Value = Language> {
    let names = Language::ALL.map(Language::name);
    PossibleValuesParser::new(names).try_map(|name| {
        let mut all = Language::ALL.into_iter();
        all.find(|language| language.name() == name)
            .ok_or("there is no such language")
    })
}

fn shard(text: &str) -> Result<[u32; 2], String> {
    let sides = text.split_once('/');
    let numbers = sides.and_then(|(own, of)| Some([own.parse().ok()?, of.parse().ok()?]));
    let numbers = numbers.filter(|[own, of]| (1..=*of).contains(own));
    numbers.ok_or_else(|| "a shard is I/N, with I from 1 to N, such as 1/2".to_owned())
}

fn size(text: &str) -> Result<(u32, u32), String> {
    let number = |text: &str| text.parse::<u32>().ok().filter(|number| *number > 0);
    text.split_once('x')
        .and_then(|(width, height)| Some((number(width)?, number(height)?)))
        .ok_or_else(|| {
            "a size is width x height in pixels, both above 0, such as 1280x720".to_owned()
        })
}

fn binding(text: &str) -> Result<(String, String), String> {
    two_sides(text).ok_or_else(|| {
        "a binding is INTERFACE=MODULE, such as package::interface::shadow=package::methods::basic"
            .to_owned()
    })
}

fn choice(text: &str) -> Result<(String, String), String> {
    two_sides(text).ok_or_else(|| "a choice is AXIS=VALUE, such as filter=hpsm".to_owned())
}

fn setting(text: &str) -> Result<(String, f64), String> {
    two_sides(text)
        .and_then(|(name, value)| Some((name, value.parse().ok()?)))
        .ok_or_else(|| "a setting is NAME=NUMBER, such as resolution=512".to_owned())
}

fn two_sides(text: &str) -> Option<(String, String)> {
    let (left, right) = text.split_once('=')?;
    let named = !left.is_empty() && !right.is_empty();
    named.then(|| (left.to_owned(), right.to_owned()))
}

/// One of the lints, by its name.
fn lint() -> impl TypedValueParser<Value = Lint> {
    let named = |name: String| Lint::ALL.iter().copied().find(|lint| lint.name() == name);
    let names = PossibleValuesParser::new(Lint::ALL.iter().map(|lint| lint.name()));
    names.try_map(move |name| named(name).ok_or("no such lint"))
}

/// One of the paths, by its name.
fn path() -> impl TypedValueParser<Value = Path> {
    let named = |name: String| Path::ALL.into_iter().find(|path| path.name() == name);
    let names = PossibleValuesParser::new(Path::ALL.map(Path::name));
    names.try_map(move |name| named(name).ok_or("no such path"))
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    #[test]
    fn the_arguments_do_not_contradict_each_other() {
        Arguments::command().debug_assert();
    }

    #[test]
    fn a_size_is_two_numbers_above_zero() {
        assert_eq!(size("640x480"), Ok((640, 480)));
        for bad in [
            "0x480",
            "640x0",
            "640",
            "640x",
            "x480",
            "-1x5",
            "640x480x2",
            "1e3x5",
            "",
            "99999999999x1",
        ] {
            assert!(size(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn a_binding_has_two_sides() {
        assert_eq!(binding("a=b"), Ok(("a".to_owned(), "b".to_owned())));
        for bad in ["a", "=b", "a=", ""] {
            assert!(binding(bad).is_err(), "{bad}");
            assert!(choice(bad).is_err(), "{bad}");
            assert!(setting(bad).is_err(), "{bad}");
        }
    }
}

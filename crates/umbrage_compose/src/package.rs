//! Packages: WESL modules in a folder, with their `wesl.toml` and their axes.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

use globset::{Glob, GlobSet, GlobSetBuilder};
use serde::Deserialize;

use crate::{
    Cause, Error, Fault,
    file::{self, SourceText},
    names::package_name,
};

/// A folder with more than this is no package of shaders.
const MOST_MODULES: usize = 10_000;

/// The name of the file that holds a package's axes.
const AXES_FILE: &str = "axes.ron";

/// The name of the file that says what belongs to a package.
const CONFIG_FILE: &str = "wesl.toml";

/// A package of WESL modules, with the axes that it offers.
#[derive(Clone, Debug)]
pub struct Package {
    pub(crate) name: String,
    /// Modules by their path within the package, joined by `::`.
    pub(crate) modules: BTreeMap<String, SourceText>,
    pub(crate) axes: Option<SourceText>,
    pub(crate) dependencies: BTreeMap<String, Dependency>,
    /// Groups by the numbers that its modules have for them.
    pub(crate) groups: BTreeMap<u32, u32>,
}

/// Another package, as a `wesl.toml` names it.
#[derive(Clone, Debug)]
pub(crate) struct Dependency {
    /// The package's own name.
    pub(crate) package: String,
    /// The folder with its `wesl.toml`.
    pub(crate) path: Option<PathBuf>,
}

impl Package {
    /// Reads the package in the folder `dir`: its `wesl.toml` where it has one, the modules that it
    /// includes, and its `axes.ron` where it has one. Other packages know it as `name`, in which `-`
    /// becomes `_`. A module that cannot be read is a fault where it is needed.
    ///
    /// # Errors
    /// A name that no path can begin with, an unreadable or malformed `wesl.toml` or `axes.ron`, and two
    /// files that are one module.
    pub fn load(name: &str, dir: &Path) -> Result<Self, Error> {
        let name = package_name(name)?;
        let config = Config::load(dir)?;
        let root = match config.root.strip_prefix(".") {
            Ok(within) if within.as_os_str().is_empty() => dir.to_owned(),
            Ok(within) => dir.join(within),
            Err(_) => dir.join(&config.root),
        };
        let mut package = Self {
            name,
            modules: BTreeMap::new(),
            axes: None,
            dependencies: config.dependencies(dir)?,
            groups: BTreeMap::new(),
        };
        if !root.is_dir() {
            return Err(Fault::new(
                Cause::File,
                format!("`{}` is not a folder of WESL modules", root.display()),
            )
            .note("give a folder that holds a wesl.toml or *.wesl files")
            .into());
        }
        let axes = dir.join(AXES_FILE);
        if axes.is_file() {
            package.axes = Some(SourceText::read(&axes)?);
        }
        let (include, exclude) = config.globs(dir)?;
        let mut folders = vec![root.clone()];
        while let Some(folder) = folders.pop() {
            if package.modules.len() > MOST_MODULES || folders.len() > MOST_MODULES {
                let message = format!(
                    "`{}` holds more than {MOST_MODULES} modules or folders",
                    root.display()
                );
                return Err(Fault::new(Cause::File, message)
                    .note("name the folder of the shaders alone, or exclude the others in its wesl.toml")
                    .into());
            }
            for entry in fs::read_dir(&folder).map_err(|error| file::unreadable(&folder, &error))? {
                let path = entry
                    .map_err(|error| file::unreadable(&folder, &error))?
                    .path();
                let relative = path.strip_prefix(dir).unwrap_or(&path);
                if exclude.is_match(relative) {
                    continue;
                }
                // A link to a folder may lead in a circle; a pipe has no end.
                let Ok(kind) = fs::symlink_metadata(&path).map(|about| about.file_type()) else {
                    continue;
                };
                if kind.is_dir() {
                    folders.push(path);
                } else if path.is_file() && is_module(&path) && include.is_match(relative) {
                    let within = path.strip_prefix(&root).unwrap_or(&path);
                    package.add(within, SourceText::load(&path))?;
                }
            }
        }
        Ok(package)
    }

    /// The same with other numbers of bind groups: an engine that has its lights in group 2, say, has a package with lights in
    /// group 1 link with `[(1, 2)]`. Groups that are not named keep theirs. Packages that share a group are given the
    /// same numbers.
    pub fn with_groups(mut self, groups: impl IntoIterator<Item = (u32, u32)>) -> Self {
        self.groups = groups.into_iter().collect();
        self
    }

    /// A package from texts: `files` are paths relative to the package's root, such as
    /// `methods/basic.wesl` or `axes.ron`, with their texts. Faults name a file as `root`/path.
    ///
    /// # Errors
    /// A name that no path can begin with, and two files that are one module.
    pub fn from_sources(
        name: &str,
        root: &str,
        files: impl IntoIterator<Item = (impl Into<String>, impl Into<String>)>,
    ) -> Result<Self, Error> {
        let mut package = Self {
            name: package_name(name)?,
            modules: BTreeMap::new(),
            axes: None,
            dependencies: BTreeMap::new(),
            groups: BTreeMap::new(),
        };
        for (path, text) in files {
            let (path, text): (String, String) = (path.into(), text.into());
            let file = if root.is_empty() {
                path.clone()
            } else {
                format!("{root}/{path}")
            };
            let source = SourceText::new(file, text);
            if path == AXES_FILE {
                package.axes = Some(source);
            } else if is_module(Path::new(&path)) {
                package.add(Path::new(&path), source)?;
            }
        }
        Ok(package)
    }

    /// Adds the module at the path `within` the package's root; returns its module path.
    pub(crate) fn add(&mut self, within: &Path, source: SourceText) -> Result<String, Error> {
        let path = module_path(within);
        if let Some(other) = self.modules.get(&path) {
            // Folders are listed in no fixed order, so sort for a stable message.
            let mut files = [&source.file, &other.file];
            files.sort();
            let [first, second] = files;
            let message = format!("`{first}` and `{second}` are the same module, `{path}`");
            return Err(Fault::new(Cause::File, message)
                .note("rename or remove one of them")
                .into());
        }
        self.modules.insert(path.clone(), source);
        Ok(path)
    }
}

fn is_module(path: &Path) -> bool {
    path.extension()
        .is_some_and(|extension| extension == "wesl" || extension == "wgsl")
}

fn module_path(within: &Path) -> String {
    let stem = within.with_extension("");
    let parts: Vec<_> = stem
        .components()
        .map(|part| part.as_os_str().to_string_lossy())
        .collect();
    parts.join("::")
}

/// A `wesl.toml`, as <https://wesl-lang.dev/spec/WeslToml> has it.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct Config {
    #[serde(rename = "edition")]
    _edition: Edition,
    #[serde(rename = "package-manager", default)]
    _package_manager: Option<String>,
    #[serde(default = "default_root")]
    root: PathBuf,
    #[serde(default = "default_include")]
    include: Vec<String>,
    #[serde(default)]
    exclude: Vec<String>,
    #[serde(default)]
    dependencies: BTreeMap<String, DependencyConfig>,
}

#[derive(Debug, Deserialize)]
enum Edition {
    #[serde(rename = "2026_pre", alias = "unstable_2025")]
    Pre2026,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct DependencyConfig {
    package: Option<String>,
    path: Option<PathBuf>,
}

fn default_root() -> PathBuf {
    "shaders".into()
}

fn default_include() -> Vec<String> {
    vec!["**/*.wesl".to_owned(), "**/*.wgsl".to_owned()]
}

impl Config {
    /// A folder without a `wesl.toml` is a package all the same: its root is the folder itself.
    fn load(dir: &Path) -> Result<Self, Error> {
        let path = dir.join(CONFIG_FILE);
        if !path.exists() {
            return Ok(Self {
                _edition: Edition::Pre2026,
                _package_manager: None,
                root: ".".into(),
                include: default_include(),
                exclude: Vec::new(),
                dependencies: BTreeMap::new(),
            });
        }
        let source = SourceText::read(&path)?;
        // The specification has the fields in a table `package`, the tools that exist at the top.
        let flat = toml::from_str::<toml::Table>(&source.text).map(|mut table| {
            if let Some(toml::Value::Table(package)) = table.remove("package") {
                table.extend(package);
            }
            table
        });
        flat.and_then(toml::Table::try_into).map_err(|error| {
            let message = format!("not a valid wesl.toml: {}", error.message());
            let fault = Fault::new(Cause::File, message);
            match error.span() {
                Some(range) => fault.at(source.place(range)),
                None => fault.in_file(&source.file, 1, 1),
            }
            .into()
        })
    }

    /// Packages that modules may refer to, by the names that they use (with `_` for `-`).
    fn dependencies(&self, dir: &Path) -> Result<BTreeMap<String, Dependency>, Error> {
        let mut dependencies = BTreeMap::new();
        for (name, config) in &self.dependencies {
            let legal = |name: &str| {
                let at = |fault: Fault| match SourceText::read(&dir.join(CONFIG_FILE)) {
                    Ok(source) => {
                        let start = source.text.find(name).filter(|_| !name.is_empty());
                        fault.at(source.place(start.map_or(0..0, |at| at..at + name.len())))
                    }
                    Err(_) => fault,
                };
                package_name(name).map_err(at)
            };
            let dependency = Dependency {
                package: legal(config.package.as_ref().unwrap_or(name))?,
                path: config.path.as_ref().map(|path| dir.join(path)),
            };
            dependencies.insert(legal(name)?, dependency);
        }
        Ok(dependencies)
    }

    fn globs(&self, dir: &Path) -> Result<(GlobSet, GlobSet), Error> {
        let build = |patterns: &[String]| {
            let mut set = GlobSetBuilder::new();
            for pattern in patterns {
                set.add(Glob::new(pattern.trim_start_matches("./"))?);
            }
            set.build()
        };
        let set = |patterns: &[String]| {
            build(patterns).map_err(|error| {
                let file = dir.join(CONFIG_FILE).display().to_string();
                Error::from(Fault::new(Cause::File, format!("{error}")).in_file(file, 1, 1))
            })
        };
        // A folder that wesl.toml leaves out need not be walked.
        let exclude: Vec<_> = self
            .exclude
            .iter()
            .flat_map(|pattern| {
                [
                    pattern.clone(),
                    format!("{}/**", pattern.trim_end_matches('/')),
                ]
            })
            .collect();
        Ok((set(&self.include)?, set(&exclude)?))
    }
}

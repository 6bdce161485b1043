//! Tables: targets as RON that a person can read.

use std::{collections::BTreeMap, path::Path};

use naga::valid::Capabilities;
use serde::Deserialize;
use umbrage_hints::did_you_mean;

use super::{Limit, Target};
use crate::{Cause, Error, Fault, RonFile, ron_text};

/// Tables that come with the crate, by their names.
macro_rules! tables {
    ($($name:literal),+) => {
        const TABLES: &[(&str, &str)] = &[$(($name, include_str!(concat!($name, ".ron")))),+];
    };
}

tables!["webgpu", "vulkan", "metal", "dx12", "gles"];

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Table {
    capabilities: Vec<String>,
    #[serde(default)]
    vertex_writes: bool,
    #[serde(default, deserialize_with = "ron_text::unique")]
    limits: BTreeMap<String, u64>,
}

impl Target {
    /// Names of the targets that come with the crate.
    pub fn names() -> impl Iterator<Item = &'static str> {
        TABLES.iter().map(|(name, _)| *name)
    }

    /// The target called `name`, of those that come with the crate.
    ///
    /// # Errors
    /// No such target.
    pub fn named(name: &str) -> Result<Self, Error> {
        let Some((_, text)) = TABLES.iter().find(|(known, _)| *known == name) else {
            let names: Vec<_> = Self::names().collect();
            let fault = Fault::new(Cause::Manifest, format!("there is no target `{name}`"));
            let choose = format!(
                "choose one of {}, or name a file that ends in .ron",
                names.join(", ")
            );
            return Err(fault
                .note(match did_you_mean(name, names.iter().copied()) {
                    Some(hint) => format!("{hint} Else {choose}"),
                    None => choose,
                })
                .into());
        };
        read(name, &RonFile::new(format!("{name}.ron"), *text))
    }

    /// Reads the target in the file at `path`, which is called like the file, without `.ron`:
    ///
    /// ```ron
    /// (
    ///     capabilities: ["CUBE_ARRAY_TEXTURES", "SHADER_FLOAT16"],
    ///     vertex_writes: false,
    ///     limits: { "maxInterStageShaderVariables": 15 },
    /// )
    /// ```
    /// Capabilities have naga's names, limits WebGPU's. Limits that are left out are WebGPU's defaults.
    ///
    /// # Errors
    /// An unreadable or malformed file, and an unknown field, capability or limit.
    pub fn load(path: &Path) -> Result<Self, Error> {
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        read(&name, &RonFile::load(path)?)
    }
}

fn read(name: &str, file: &RonFile) -> Result<Target, Error> {
    let table: Table = file.parse()?;
    let mut capabilities = Capabilities::empty();
    for (index, given) in table.capabilities.iter().enumerate() {
        let Some(one) = Capabilities::from_name(given) else {
            let range = file.at(&format!("capabilities[{index}]"));
            let fault = file.fault(format!("naga has no capability `{given}`"), range, &[]);
            let all = Capabilities::all();
            let known = all.iter_names().map(|(name, _)| name);
            return Err(hinted(fault, did_you_mean(given, known), "capability").into());
        };
        capabilities |= one;
    }
    let mut target = Target::new(name, capabilities);
    for (given, value) in &table.limits {
        let Some(limit) = Limit::ALL.iter().find(|limit| limit.name() == given) else {
            let range = file.at("limits");
            let fault = file.fault(
                format!("there is no limit `{given}` that a shader may exceed"),
                range,
                &[given],
            );
            let known = Limit::ALL.iter().map(|limit| limit.name());
            return Err(hinted(fault, did_you_mean(given, known), "limit").into());
        };
        target = target.with_limit(*limit, *value);
    }
    Ok(match table.vertex_writes {
        true => target.with_vertex_writes(),
        false => target,
    })
}

fn hinted(fault: Fault, hint: Option<String>, what: &str) -> Fault {
    fault.note(hint.unwrap_or_else(|| {
        format!("remove it, or name another {what}; the crate's own tables show how")
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_table_is_read() {
        for name in Target::names() {
            let target = Target::named(name).expect("a table");
            assert_eq!(target.name(), name);
        }
        assert_eq!(Target::named("webgpu").expect("a table"), Target::webgpu());
        // No table lies there unlisted.
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/target");
        let files = std::fs::read_dir(folder).expect("a folder");
        let tables = files.filter(|file| {
            let path = file.as_ref().expect("a file").path();
            path.extension().is_some_and(|end| end == "ron")
        });
        assert_eq!(tables.count(), Target::names().count());
    }

    #[test]
    fn what_is_wrong_in_a_table_has_a_place() {
        for (text, at, said) in [
            (
                "(\n    capabilities: [\"FLOAT64\", \"SHADER_FLOAT61\"],\n)",
                (2, 31),
                "`SHADER_FLOAT16`",
            ),
            (
                "(\n    capabilities: [],\n    limits: {\n        \"maxBindGruops\": 4,\n    },\n)",
                (4, 9),
                "`maxBindGroups`",
            ),
            (
                "(\n    capabilities: [],\n    limit: {},\n)",
                (3, 5),
                "`limits`",
            ),
        ] {
            let error = read("own", &RonFile::new("own.ron", text)).expect_err("refused");
            let fault = &error.faults()[0];
            let found = fault.location().map(|place| (place.line, place.column));
            assert_eq!(found, Some(at), "{fault}");
            assert!(error.to_string().contains(said), "{error}");
        }
        let error = Target::named("vulcan").expect_err("refused").to_string();
        assert!(error.contains("did you mean `vulkan`?"), "{error}");
    }
}

//! Where RADV is, and which GPUs it may stand in for.

use std::{
    env,
    ffi::{OsStr, OsString},
    path::{Path, PathBuf},
};

use crate::IsaError;

/// Names of families that some version of Mesa has: what is tried where a name is unknown. In the order of
/// their making.
pub(crate) const FAMILIES: [&str; 46] = [
    "tahiti",
    "pitcairn",
    "verde",
    "oland",
    "hainan",
    "bonaire",
    "kaveri",
    "kabini",
    "hawaii",
    "tonga",
    "iceland",
    "carrizo",
    "fiji",
    "stoney",
    "polaris10",
    "polaris11",
    "polaris12",
    "vegam",
    "vega10",
    "vega12",
    "vega20",
    "raven",
    "raven2",
    "renoir",
    "mi100",
    "mi200",
    "navi10",
    "navi12",
    "navi14",
    "navi21",
    "navi22",
    "navi23",
    "navi24",
    "vangogh",
    "rembrandt",
    "gfx1036",
    "gfx1100",
    "gfx1101",
    "gfx1102",
    "gfx1103_r1",
    "navi31",
    "navi32",
    "navi33",
    "navi44",
    "navi48",
    "gfx1150",
];

/// Whether `text` may name a family at all.
pub(crate) fn may_be_family(text: &str) -> bool {
    let part = |byte: u8| byte.is_ascii_alphanumeric() || byte == b'_';
    !text.is_empty() && text.bytes().all(part)
}

/// Whether `device`, a device's own name, is of `family`: such as `Null hardware (RADV NAVI21)`.
pub(crate) fn is_of_family(device: &str, family: &str) -> bool {
    let mut words = device.split(|c: char| !c.is_ascii_alphanumeric() && c != '_');
    words.any(|word| word.eq_ignore_ascii_case(family))
}

/// The driver's manifests, for the loader's variable: those that this machine's environment names, or else
/// those in `folders`.
pub(crate) fn manifests(folders: &[PathBuf]) -> Result<OsString, IsaError> {
    let named = ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"].iter();
    let named = named.filter_map(env::var_os);
    let named = named.flat_map(|files| env::split_paths(&files).collect::<Vec<_>>());
    let mut found: Vec<_> = named
        .filter(|file| file.file_name().is_some_and(is_manifest) && file.is_file())
        .collect();
    for folder in folders {
        if found.is_empty() {
            found = in_folder(folder);
        }
    }
    env::join_paths(&found)
        .ok()
        .filter(|_| !found.is_empty())
        .ok_or_else(|| IsaError::NoDriver {
            looked: folders.to_vec(),
        })
}

/// The folders in which the Vulkan loader looks for manifests of drivers, in its order.
pub(crate) fn folders() -> Vec<PathBuf> {
    let home = env::var_os("HOME").map(PathBuf::from);
    let below_home = |path: &str| home.as_ref().map(|home| home.join(path));
    let one = |name: &str| env::var_os(name).filter(|value| !value.is_empty());
    let several = |name: &str, default: &str| {
        let value = one(name).unwrap_or_else(|| default.into());
        env::split_paths(&value).collect::<Vec<_>>()
    };
    let config_home = one("XDG_CONFIG_HOME").map(PathBuf::from);
    let data_home = one("XDG_DATA_HOME").map(PathBuf::from);
    let mut roots = Vec::new();
    roots.extend(config_home.or_else(|| below_home(".config")));
    roots.extend(several("XDG_CONFIG_DIRS", "/etc/xdg"));
    roots.extend(["/usr/local/etc".into(), "/etc".into()]);
    roots.extend(data_home.or_else(|| below_home(".local/share")));
    roots.extend(several("XDG_DATA_DIRS", "/usr/local/share:/usr/share"));
    roots
        .into_iter()
        .filter(|root| root.is_absolute())
        .map(|root| root.join("vulkan/icd.d"))
        .collect()
}

fn in_folder(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = folder.read_dir() else {
        return Vec::new();
    };
    let files = entries.filter_map(|entry| Some(entry.ok()?.path()));
    let mut files: Vec<_> = files
        .filter(|path| path.file_name().is_some_and(is_manifest))
        .collect();
    files.sort();
    // Debian's names hold the architecture; a driver of another one cannot be loaded.
    let own = format!("radeon_icd.{}.json", env::consts::ARCH);
    match files.iter().find(|path| path.ends_with(&own)) {
        Some(own) => vec![own.clone()],
        None => files,
    }
}

fn is_manifest(name: &OsStr) -> bool {
    let name = name.to_string_lossy();
    name.starts_with("radeon_icd") && name.ends_with(".json")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_device_names_its_family() {
        for (device, family, is) in [
            ("Null hardware (RADV NAVI21)", "navi21", true),
            ("Null hardware (RADV GFX1103_R1)", "gfx1103_r1", true),
            ("Null hardware (RADV GFX1103_R1)", "gfx1103", false),
            ("Null hardware (RADV NAVI21)", "navi2", false),
            ("llvmpipe (LLVM 15.0.6, 256 bits)", "navi21", false),
        ] {
            assert_eq!(is_of_family(device, family), is, "{device} {family}");
        }
    }

    #[test]
    fn a_family_is_a_word() {
        for (name, may) in [
            ("navi21", true),
            ("gfx1103_r1", true),
            ("", false),
            ("../navi21", false),
            ("a b", false),
            ("navi\0", false),
        ] {
            assert_eq!(may_be_family(name), may, "{name:?}");
        }
    }

    #[test]
    fn manifests_are_found_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str| std::fs::write(folder.path().join(name), "{}").unwrap();
        assert!(in_folder(folder.path()).is_empty());
        write("lvp_icd.json");
        assert!(in_folder(folder.path()).is_empty());
        write("radeon_icd.json");
        assert_eq!(
            in_folder(folder.path()),
            [folder.path().join("radeon_icd.json")]
        );
        let own = format!("radeon_icd.{}.json", env::consts::ARCH);
        write(&own);
        assert_eq!(in_folder(folder.path()), [folder.path().join(own)]);
        assert!(in_folder(&folder.path().join("gone")).is_empty());
    }
}

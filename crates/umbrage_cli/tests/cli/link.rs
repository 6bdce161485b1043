use naga::valid::{Capabilities, ValidationFlags, Validator};

use super::{faulty_package, path_in, refusal, root, stderr, stdout, umbrage, write};

fn link(args: &[&str]) -> String {
    let mut all = vec!["link"];
    all.extend(args);
    let output = umbrage(&all);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let wgsl = stdout(&output).to_owned();
    let module = naga::front::wgsl::parse_str(&wgsl)
        .map_err(|error| format!("{error} in\n{wgsl}"))
        .expect("WGSL");
    Validator::new(ValidationFlags::all(), Capabilities::empty())
        .validate(&module)
        .map_err(|error| format!("{error} in\n{wgsl}"))
        .expect("valid");
    wgsl
}

#[test]
fn a_module_with_what_it_reaches() {
    let folder = faulty_package();
    let (main, pkg) = (path_in(&folder, "pkg/main.wesl"), path_in(&folder, "pkg"));
    let bind = "package::interface::shadow=package::bad";
    let wgsl = link(&[&main, "--package", &pkg, "--bind", bind]);
    assert!(
        wgsl.contains("fs_main") && wgsl.contains("calc_shadow"),
        "{wgsl}"
    );
    assert!(!wgsl.contains("import"), "{wgsl}");

    let said = refusal(&[
        "link",
        &main,
        "--package",
        &pkg,
        "--bind",
        bind,
        "--feature",
        "LAMP",
    ]);
    assert!(said.contains("bad.wesl:2"), "{said}");
}

/// The command that README.md gives.
#[test]
fn the_front_page_links() {
    let page = std::fs::read_to_string(root().join("README.md")).expect("the front page");
    let page = page.replace("\\\n", " ");
    let mut commands = page.lines().filter_map(|line| {
        let words = line.strip_prefix("cargo run --bin umbrage -- link ")?;
        Some(words.split_whitespace().collect::<Vec<_>>())
    });
    let words = commands.next().expect("a command");
    assert!(link(&words).contains("calc_shadow"));
}

#[test]
fn a_file_by_itself() {
    let folder = faulty_package();
    write(
        &folder,
        "alone.wesl",
        "fn unused() -> f32 { return 2.0; }\n@if(WIDE) const WIDTH: u32 = 7u;\n",
    );
    let alone = path_in(&folder, "alone.wesl");
    let wgsl = link(&[&alone]);
    assert!(wgsl.contains("unused") && !wgsl.contains("WIDTH"), "{wgsl}");
    assert!(link(&[&alone, "--feature", "WIDE"]).contains("WIDTH"));
}

#[test]
fn a_file_of_a_package_with_a_wesl_toml() {
    let wgsl = link(&["shader_lib/passes/base.wesl"]);
    assert!(
        wgsl.contains("vs_base") && wgsl.contains("fs_base"),
        "{wgsl}"
    );
}

#[test]
fn what_cannot_be_linked() {
    let folder = faulty_package();
    assert!(refusal(&["link", "gone.wesl"]).contains("gone.wesl"));
    let (main, pkg) = (path_in(&folder, "pkg/main.wesl"), path_in(&folder, "pkg"));
    let said = refusal(&[
        "link",
        &main,
        "--package",
        &pkg,
        "--bind",
        "package::interface::shadow=package::god",
    ]);
    assert!(said.contains("god"), "{said}");
    write(&folder, "broken.wesl", "fn f( {}\n");
    assert!(refusal(&["link", &path_in(&folder, "broken.wesl")]).contains("broken.wesl:1"));
}

/// A host's name stays, and so does a member that has it too.
#[test]
fn names_that_end_in_a_digit() {
    let folder = faulty_package();
    write(
        &folder,
        "alone.wesl",
        "override K1: f32 = 1.0;\nstruct P { K1: f32 }\n@group(0) @binding(0) var<uniform> p: P;\n\
         @fragment fn fs() -> @location(0) vec4f { return vec4f(p.K1 * K1); }\n",
    );
    let wgsl = link(&[&path_in(&folder, "alone.wesl")]);
    assert!(
        wgsl.contains("override K1: f32") && wgsl.contains("    K1: f32,"),
        "{wgsl}"
    );
}

#[test]
fn filters_are_kept_and_what_they_allow_is_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = "@diagnostic(warning, derivative_uniformity)
@fragment fn fs(@location(0) x: f32) -> @location(0) vec4f {
    if x > 0.5 {
        return vec4f(dpdx(x));
    }
    return vec4f();
}
";
    write(&folder, "main.wgsl", text);
    let output = umbrage(&["link", &path_in(&folder, "main.wgsl")]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let directive = "diagnostic(warning, derivative_uniformity);\n";
    assert!(
        stdout(&output).starts_with(directive),
        "{}",
        stdout(&output)
    );
    let said = stderr(&output);
    assert!(said.starts_with("warning: `dpdx` must only be called from uniform control flow"));
    assert!(said.contains("main.wgsl:4:22"), "{said}");
}

//! Arguments that cannot be used.

use super::{refusal, stderr, stdout, umbrage, umbrage_with};

const SCENE: &str = "examples/scenes/bunny_sun.ron";

#[test]
fn nothing_at_all() {
    assert_eq!(umbrage(&[]).status.code(), Some(2));
    assert_eq!(umbrage(&["--help"]).status.code(), Some(0));
}

#[test]
fn sizes() {
    for size in [
        "0x100", "100x0", "100", "x", "100x", "-1x100", "1e9x1", "NaNxNaN",
    ] {
        let said = refusal(&[
            "render",
            SCENE,
            &format!("--size={size}"),
            "--out",
            "never.png",
        ]);
        assert!(said.contains("such as 1280x720"), "{said}");
    }
}

#[test]
fn missing_and_unknown() {
    assert!(refusal(&["render", SCENE]).contains("--out"));
    assert!(refusal(&["render", "--out", "never.png"]).contains("<SCENE>"));
    assert!(
        refusal(&["render", SCENE, "--what", "heat", "--out", "never.png"]).contains("shadow-term")
    );
    assert!(refusal(&["check"]).contains("MANIFEST"));
    assert!(refusal(&["check", "permutations/demo.ron", "--target", "gameboy"]).contains("webgpu"));
    assert!(refusal(&["prebuild", "permutations/demo.ron"]).contains("--out"));
    assert!(refusal(&["link", "x.wesl", "--bind", "interface"]).contains("INTERFACE=MODULE"));
    assert!(refusal(&["chek"]).contains("check"));
}

#[test]
fn the_adapter_has_a_name() {
    let output = umbrage(&["adapter"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_eq!(stdout(&output).trim().lines().count(), 1);
}

#[test]
fn no_adapter() {
    // The loader is pointed to a driver that does not exist.
    let output = umbrage_with(&["adapter"], &[("VK_DRIVER_FILES", "/nonexistent.json")]);
    assert_eq!(output.status.code(), Some(2));
    assert_eq!(stdout(&output), "");
    // These words are what xtask tells a machine without an adapter by.
    assert!(
        stderr(&output).contains("no Vulkan adapter was found"),
        "{}",
        stderr(&output)
    );
    assert!(
        stderr(&output).contains("mesa-vulkan-drivers"),
        "{}",
        stderr(&output)
    );
}

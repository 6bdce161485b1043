//! Drivers that are missing, crash or hang, and what cannot be compiled.

use std::{path::PathBuf, thread, time::Duration};

use umbrage_isa::{
    ColorTarget, Compiler, CompilerOptions, IsaError, PipelineState, costs, testing::serve_if_asked,
};
use wgpu_types::TextureFormat;

use super::{compiler, cost, of_module, options, permutation};

/// A server that dies of passes called `base`.
#[test]
fn server_that_crashes() {
    serve_if_asked(&|entry_points| {
        if entry_points.contains(&"fs_base") {
            eprintln!("out of luck");
            std::process::abort();
        }
    });
}

/// A server that never comes to an end with passes called `base`.
#[test]
fn server_that_hangs() {
    serve_if_asked(&|entry_points| {
        if entry_points.contains(&"fs_base") {
            thread::sleep(Duration::from_secs(600));
        }
    });
}

fn refusal(options: &CompilerOptions) -> IsaError {
    Compiler::with(options).err().expect("no compiler")
}

#[test]
fn a_crash_is_one_permutations_own() {
    let options = options("navi21", "trouble::server_that_crashes");
    let passes = ["caster", "base", "shadow_term"].map(|pass| permutation(&[("pass", pass)]));
    let jobs = passes.each_ref().map(|p| (&**p, PipelineState::of(p)));
    let results = costs(&options, &jobs, &|| ()).expect("figures");
    assert!(results[0].is_ok() && results[2].is_ok(), "{results:?}");
    let error = results[1].as_ref().expect_err("a crash");
    assert!(matches!(error, IsaError::Crashed { .. }), "{error:?}");
    let said = error.to_string();
    for part in ["pass=base", "signal", "out of luck"] {
        assert!(said.contains(part), "{said}");
    }
    // One compiler goes on, too.
    let mut compiler = Compiler::with(&options).expect("a compiler");
    let mut compile = |index: usize| compiler.cost(jobs[index].0, &jobs[index].1);
    assert!(compile(1).is_err() && compile(1).is_err());
    assert_eq!(compile(2).ok(), results[2].as_ref().ok().cloned());
}

#[test]
fn a_hang_comes_to_an_end() {
    let options = CompilerOptions {
        limit: Duration::from_secs(2),
        ..options("navi21", "trouble::server_that_hangs")
    };
    let mut compiler = Compiler::with(&options).expect("a compiler");
    let base = permutation(&[("pass", "base")]);
    let error = compiler
        .cost(&base, &PipelineState::of(&base))
        .expect_err("a hang");
    assert!(matches!(error, IsaError::TimedOut { .. }), "{error:?}");
    assert!(error.to_string().contains("pass=base"), "{error}");
    let caster = permutation(&[("pass", "caster")]);
    assert_eq!(cost(&mut compiler, &caster).len(), 1);
}

#[test]
fn no_driver() {
    let folder = tempfile::tempdir().expect("a folder");
    let error = refusal(&CompilerOptions {
        folders: vec![folder.path().to_owned()],
        ..options("navi21", "server")
    });
    assert!(matches!(error, IsaError::NoDriver { .. }), "{error:?}");
    let said = error.to_string();
    assert!(said.contains("mesa-vulkan-drivers"), "{said}");
    assert!(
        said.contains(&folder.path().display().to_string()),
        "{said}"
    );
}

/// A manifest of a driver that cannot be loaded is no driver either.
#[test]
fn a_broken_driver() {
    let folder = tempfile::tempdir().expect("a folder");
    let manifest = r#"{ "ICD": { "api_version": "1.3.0", "library_path": "/gone.so" }, "file_format_version": "1.0.0" }"#;
    std::fs::write(folder.path().join("radeon_icd.json"), manifest).expect("a file");
    let error = refusal(&CompilerOptions {
        folders: vec![folder.path().to_owned()],
        ..options("navi21", "server")
    });
    assert!(matches!(error, IsaError::NoDevice { .. }), "{error:?}");
}

#[test]
fn an_unknown_family() {
    let error = refusal(&options("navi99", "server"));
    let IsaError::Family { family, known } = &error else {
        panic!("{error:?}");
    };
    assert_eq!(family, "navi99");
    assert!(known.iter().any(|known| known == "navi21"), "{known:?}");
    assert!(!known.contains(family));
    assert!(error.to_string().contains("vega10"), "{error}");
}

#[test]
fn a_program_that_does_not_serve() {
    let of = |program: &str, args: &[&str]| {
        refusal(&CompilerOptions {
            program: PathBuf::from(program),
            args: args.iter().map(Into::into).collect(),
            ..CompilerOptions::default()
        })
    };
    let error = of("/gone/umbrage", &[]);
    assert!(matches!(error, IsaError::Start { .. }), "{error:?}");
    for (program, args) in [
        ("true", &[][..]),
        ("sh", &["-c", "echo something else >&2; exit 3"]),
    ] {
        let error = of(program, args);
        assert!(matches!(error, IsaError::NotServing { .. }), "{error:?}");
        assert!(error.to_string().contains("serve_if_asked"), "{error}");
    }
    let said = of("sh", &["-c", "echo something else >&2"]).to_string();
    assert!(said.contains("something else"), "{said}");
    // This program, without the one test that serves: it must not start itself for ever.
    let error = refusal(&options("navi21", "trouble::no_such_test"));
    assert!(matches!(error, IsaError::NotServing { .. }), "{error:?}");
}

#[test]
fn what_is_no_pipeline() {
    let mut compiler = compiler("navi21");
    let mut refused = |text: &str, state: Option<PipelineState>| {
        let permutation = of_module(text);
        let state = state.unwrap_or_else(|| PipelineState::of(&permutation));
        let error = compiler.cost(&permutation, &state).expect_err("refused");
        assert!(matches!(error, IsaError::Refused { .. }), "{error:?}");
        error.to_string()
    };
    let lone = "@fragment fn fs_own() -> @location(0) f32 { return 1.0; }";
    let said = refused(lone, None);
    assert!(said.contains("fs_own") && said.contains("vertex"), "{said}");
    assert!(said.contains("pass=own"), "{said}");
    let whole =
        format!("{lone} @vertex fn vs_own() -> @builtin(position) vec4f {{ return vec4f(); }}");
    let state = PipelineState {
        colors: vec![Some(ColorTarget {
            format: TextureFormat::Bc1RgbaUnorm,
            blend: None,
        })],
        ..PipelineState::default()
    };
    let said = refused(&whole, Some(state));
    assert!(said.contains("Bc1RgbaUnorm"), "{said}");
}

//! A method of another package cannot forget to count a texture fetch.
#![allow(
    clippy::panic,
    reason = "a test's helpers may fail it, with the error's own words"
)]

use std::path::Path;

use umbrage_compose::{Composer, Error, Library, Package, Target};

const AXES: &str = r#"(axes: {
    "method": (values: {
        "mine": (bind: { "umbrage::interface::shadow": "package::methods::mine" }),
    }),
})"#;

/// A method whose `calc_shadow` has this body.
fn method(body: &str) -> String {
    format!(
        "@if(COUNT_FETCHES) import umbrage::common::fetches::count_fetch;
import package::taps::tap;

@group(1) @binding(0) var map: texture_2d<f32>;
@group(1) @binding(1) var map_sampler: sampler;

fn calc_shadow(position_ws: vec3f) -> f32 {{
{body}
}}
"
    )
}

const TAPS: &str = "@if(COUNT_FETCHES) import umbrage::common::fetches::count_fetch;
fn tap(map: texture_2d<f32>, at: vec2i) -> f32 {
    @if(COUNT_FETCHES) count_fetch();
    return textureLoad(map, at, 0).x;
}
";

fn compose_with(pass: &str, body: &str, taps: &str) -> Result<(), Error> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shader_lib");
    let umbrage = Package::load("umbrage", &folder)?;
    let files = [
        ("axes.ron", AXES),
        ("methods/mine.wesl", &method(body)),
        ("taps.wesl", taps),
    ];
    let files = files.map(|(path, text)| (path.to_owned(), text.to_owned()));
    let library = Library::new([umbrage, Package::from_sources("mine", "mine", files)?])?;
    let choices = [
        ("pass", pass),
        ("method", "mine"),
        ("alpha_test", "on"),
        ("base_color_texture", "on"),
    ];
    let key = library.key(choices)?;
    Composer::new(library, Target::webgpu())
        .compose(&key)
        .map(drop)
}

#[track_caller]
fn refused(body: &str) -> String {
    compose_with("fetch_count", body, TAPS)
        .expect_err("a fetch goes uncounted")
        .to_string()
}

const SAMPLE: &str = "textureSampleLevel(map, map_sampler, position_ws.xy, 0.0).x";
const COUNT: &str = "    @if(COUNT_FETCHES) count_fetch();\n";

#[test]
fn a_forgotten_count_is_told_where_the_fetch_is() {
    insta::assert_snapshot!("forgotten", refused(&format!("    return {SAMPLE};")));
    let elsewhere = compose_with(
        "fetch_count",
        "    return tap(map, vec2i());",
        &TAPS.replace("    @if(COUNT_FETCHES) count_fetch();\n", ""),
    );
    let told = elsewhere.expect_err("a fetch goes uncounted").to_string();
    insta::assert_snapshot!("forgotten_in_a_helper", told);
}

#[test]
fn a_count_must_stand_where_its_fetch_is() {
    let cases = [
        // One count for two fetches, the second in a branch of its own, the other way round, in a loop.
        format!("{COUNT}    return {SAMPLE} + {SAMPLE};"),
        format!("{COUNT}    if position_ws.x > 0.0 {{ return {SAMPLE}; }}\n    return 1.0;"),
        format!("    let term = {SAMPLE};\n{COUNT}    return term;"),
        format!(
            "{COUNT}    for (var i = 0; i < 4; i++) {{ if {SAMPLE} > 0.5 {{ return 0.0; }} }}\n    return 1.0;"
        ),
        // The right of an `and` is a branch, too.
        format!(
            "{COUNT}    if position_ws.x > 0.0 && {SAMPLE} > 0.5 {{ return 0.0; }}\n    return 1.0;"
        ),
        // A gather, a load and a comparison are fetches like any other.
        "    return textureGather(0, map, map_sampler, position_ws.xy).y;".to_owned(),
        "    return textureLoad(map, vec2i(position_ws.xy), 0).x;".to_owned(),
    ];
    for body in cases {
        let told = refused(&body);
        let place = told.contains("mine/methods/mine.wesl:");
        let what = told
            .contains("`mine::methods::mine` fetches from a texture without counting it")
            || told.contains("`mine::methods::mine` counts a texture fetch that does not follow");
        let key = told.contains("method=mine") && told.contains("pass=fetch_count");
        assert!(place && what && key, "{body}\n{told}");
    }
}

#[test]
fn what_is_counted_is_composed() {
    let sound = [
        "    return 1.0;".to_owned(),
        "    return tap(map, vec2i());".to_owned(),
        format!("{COUNT}    return {SAMPLE};"),
        format!("{COUNT}{COUNT}    return {SAMPLE} + {SAMPLE};"),
        format!("{COUNT}    let near = {SAMPLE} * tap(map, vec2i());\n    return near;"),
        format!(
            "    for (var i = 0; i < 4; i++) {{\n{COUNT}    if {SAMPLE} > 0.5 {{ return 0.0; }} }}\n    return 1.0;"
        ),
        format!(
            "    if position_ws.x > 0.0 {{\n{COUNT}        if {SAMPLE} > 0.5 {{ return 0.0; }}\n    }}\n    return 1.0;"
        ),
        // Asking a texture about itself fetches nothing.
        "    return f32(textureDimensions(map).x);".to_owned(),
    ];
    for body in sound {
        // The alpha test's fetch in the same pass is the material's own.
        compose_with("fetch_count", &body, TAPS).unwrap_or_else(|error| panic!("{error}"));
        compose_with("shadow_term", &body, TAPS).unwrap_or_else(|error| panic!("{error}"));
    }
    // Where nothing counts, nothing has to be counted.
    let forgotten = format!("    return {SAMPLE};");
    compose_with("shadow_term", &forgotten, TAPS).unwrap_or_else(|error| panic!("{error}"));
}

#[test]
fn a_demand_must_name_modules_that_exist() {
    let demand = r#"(axes: { "pass": (values: {
        "counted": (root: "package::taps", count_fetches: (call: "package::tapz::tap")),
    }) })"#;
    let files = [("axes.ron", demand), ("taps.wesl", "fn tap() {}\n")];
    let files = files.map(|(path, text)| (path.to_owned(), text.to_owned()));
    let package = Package::from_sources("mine", "mine", files).expect("texts");
    let told = Library::new([package])
        .expect_err("no such module")
        .to_string();
    assert!(
        told.contains("no module `mine::tapz`") && told.contains("mine/axes.ron"),
        "{told}"
    );
}

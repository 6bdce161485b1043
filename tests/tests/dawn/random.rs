//! Shaders made at random, at the borders of what WGSL allows: constants in and out of range, calls that alias, loops
//! with and without an exit, sizes at their limits.

use std::fmt::Write as _;

use umbrage_tests::Random;

/// The shader numbered `seed`, the same always.
pub(crate) fn shader(seed: u64) -> String {
    let mut rng = Random::new(seed);
    match rng.below(4) {
        0 | 1 => constants(&mut rng),
        2 => match rng.one_in(2) {
            true => aliases(&mut rng),
            false => sizes(&mut rng),
        },
        _ => flow(&mut rng),
    }
}

/// Types of an expression, `f32`, `i32` and `u32`, by the letter that a template has for each.
const KINDS: [char; 3] = ['f', 'i', 'u'];

const FLOATS: [&str; 12] = [
    "0.0", "1.0", "-1.0", "0.5", "2.0f", "3.0", "65504.0", "65505.0", "3e38f", "-3e38", "1e-30",
    "100.0",
];
const INTEGERS: [&str; 11] = [
    "0",
    "1",
    "-1",
    "2i",
    "3",
    "31i",
    "32",
    "127",
    "128",
    "129",
    "2147483647",
];
const NATURALS: [&str; 11] = [
    "0u",
    "1u",
    "2",
    "3u",
    "16u",
    "31u",
    "32",
    "33u",
    "0x7c00u",
    "0x7f800000u",
    "4294967295u",
];

const OF_FLOAT: [&str; 38] = [
    "f + f",
    "f - f",
    "f * f",
    "f / f",
    "-f",
    "clamp(f, f, f)",
    "smoothstep(f, f, f)",
    "ldexp(variable_f, i)",
    "quantizeToF16(f)",
    "unpack2x16float(u).x",
    "bitcast<f32>(u)",
    "bitcast<f32>(i)",
    "sqrt(f)",
    "log(f)",
    "log2(f)",
    "exp(f)",
    "exp2(f)",
    "acos(f)",
    "asin(f)",
    "acosh(f)",
    "atanh(f)",
    "pow(f, f)",
    "mix(f, f, f)",
    "fma(f, f, f)",
    "length(vec2f(f, f))",
    "normalize(vec2f(f, f)).y",
    "dot(vec2f(f, f), vec2f(f, f))",
    "min(f, f)",
    "max(f, f)",
    "abs(f)",
    "floor(f)",
    "degrees(f)",
    "step(f, f)",
    "saturate(f)",
    "f32(i)",
    "f32(u)",
    "vec2f(f, f)[i]",
    "select(f, f, i < i)",
];
const OF_INTEGER: [&str; 20] = [
    "i + i",
    "i - i",
    "i * i",
    "i / i",
    "i % i",
    "-i",
    "i << u",
    "i >> u",
    "i & i",
    "extractBits(i, u, u)",
    "insertBits(i, i, u, u)",
    "clamp(i, i, i)",
    "i32(f)",
    "i32(u)",
    "bitcast<i32>(f)",
    "min(i, i)",
    "abs(i)",
    "three[i]",
    "array(1, 2, 3)[u]",
    "(vec2i(i, i) / vec2i(i)).x",
];
const OF_NATURAL: [&str; 17] = [
    "u + u",
    "u - u",
    "u * u",
    "u / u",
    "u % u",
    "u << u",
    "u >> u",
    "u | u",
    "extractBits(u, u, u)",
    "insertBits(u, u, u, u)",
    "clamp(u, u, u)",
    "u32(f)",
    "u32(i)",
    "pack2x16float(vec2f(f, f))",
    "bitcast<u32>(f)",
    "(vec2u(u, u) % vec2u(u)).y",
    "(vec2u(u, u) << vec2u(u)).y",
];

fn literal(rng: &mut Random, kind: char) -> &'static str {
    match kind {
        'f' => rng.choose(&FLOATS),
        'i' => rng.choose(&INTEGERS),
        _ => rng.choose(&NATURALS),
    }
}

/// An expression that gives `kind`: a literal, something declared, or a template filled in.
fn expression(rng: &mut Random, kind: char, depth: u32) -> String {
    if depth == 0 {
        return match rng.below(10) {
            0..6 => format!("({})", literal(rng, kind)),
            6 => format!("variable_{kind}"),
            7 => format!("let_{kind}"),
            8 => format!("CONSTANT_{kind}"),
            _ => format!("override_{kind}"),
        };
    }
    let template = match kind {
        'f' => rng.choose(&OF_FLOAT),
        'i' => rng.choose(&OF_INTEGER),
        _ => rng.choose(&OF_NATURAL),
    };
    let mut filled = "(".to_owned();
    let letters: Vec<_> = template.chars().collect();
    for (at, letter) in letters.iter().enumerate() {
        let word = |index: Option<usize>| {
            let letter = index.and_then(|index| letters.get(index));
            letter.is_some_and(|c| c.is_alphanumeric() || *c == '.')
        };
        let alone = !word(at.checked_sub(1)) && !word(Some(at + 1));
        if alone && KINDS.contains(letter) {
            let depth = if rng.below(5) == 0 { depth - 1 } else { 0 };
            filled += &expression(rng, *letter, depth);
        } else {
            filled.push(*letter);
        }
    }
    filled + ")"
}

fn constants(rng: &mut Random) -> String {
    let mut text = String::new();
    let mut body = "    var three = array(1, 2, 3);\n".to_owned();
    for (kind, ty) in KINDS.iter().zip(["f32", "i32", "u32"]) {
        let [constant, override_, variable] = [(); 3].map(|()| literal(rng, *kind));
        // Naga takes what a `let` names for a constant here and there: only what is in range is judged alike.
        let let_ = match kind {
            'f' => literal(rng, *kind),
            'i' => "1",
            _ => "1u",
        };
        let _ = writeln!(text, "const CONSTANT_{kind}: {ty} = {constant};");
        let _ = writeln!(text, "override override_{kind}: {ty} = {override_};");
        let _ = writeln!(body, "    let let_{kind}: {ty} = {let_};");
        let _ = writeln!(body, "    var variable_{kind}: {ty} = {variable};");
    }
    let kind = KINDS[rng.below(3)];
    let _ = writeln!(body, "    let result = {};", expression(rng, kind, 2));
    format!("{text}@compute @workgroup_size(1) fn cs() {{\n{body}}}\n")
}

fn aliases(rng: &mut Random) -> String {
    let mut text = "var<private> shared_a: i32;\nvar<private> shared_b: i32;\n".to_owned();
    let functions = 1 + rng.below(3);
    for function in 0..functions {
        let space = if rng.one_in(2) { "function" } else { "private" };
        let parameters: Vec<_> = (0..3).map(|p| format!("p{p}: ptr<{space}, i32>")).collect();
        let _ = writeln!(
            text,
            "// {space}\nfn f{function}({}) {{",
            parameters.join(", ")
        );
        for _ in 0..rng.below(3) {
            let pointer = rng.below(3);
            let statement = match rng.below(7) {
                0 | 1 => format!("*p{pointer} = 1;"),
                2 => format!("_ = *p{pointer};"),
                3 => "shared_a = 2;".to_owned(),
                4 => "_ = shared_a;".to_owned(),
                5 => format!("if shared_b > 1 {{ *p{pointer} += 1; }}"),
                _ => {
                    let callee = rng.below(functions);
                    let fits =
                        callee < function && text.contains(&format!("// {space}\nfn f{callee}("));
                    if fits {
                        format!(
                            "f{callee}(p{}, p{}, p{})",
                            rng.below(3),
                            rng.below(3),
                            pointer
                        ) + ";"
                    } else {
                        String::new()
                    }
                }
            };
            let _ = writeln!(text, "    {statement}");
        }
        text += "}\n";
    }
    let callee = rng.below(functions);
    let local = text.contains(&format!("// function\nfn f{callee}("));
    let names = if local {
        ["a", "b"]
    } else {
        ["shared_a", "shared_b"]
    };
    let arguments: Vec<_> = (0..3).map(|_| format!("&{}", rng.choose(&names))).collect();
    let call = format!("f{callee}({});", arguments.join(", "));
    format!(
        "{text}@compute @workgroup_size(1) fn cs() {{\n    var a = 1;\n    var b = 2;\n    {call}\n}}\n"
    )
}

fn sizes(rng: &mut Random) -> String {
    let side = [
        "1", "2", "15", "16", "17", "64", "65", "255", "256", "257", "N",
    ];
    let [x, y, z] = [(); 3].map(|()| match rng.below(3) {
        0 => rng.choose(&side),
        _ => "1",
    });
    let element = rng.choose(&[
        "f32",
        "vec3f",
        "mat3x3f",
        "bool",
        "atomic<u32>",
        "array<vec2f, 3>",
        "S",
    ]);
    let count = rng.choose(&[
        "1", "255", "256", "341", "342", "682", "683", "1023", "1024", "1025", "4095", "4096",
        "4097", "N",
    ]);
    let n = rng.choose(&["1", "64", "256", "257", "5000"]);
    format!(
        "override N = {n};\nstruct S {{\n    a: f32,\n    b: bool,\n    c: vec3f,\n}}\nvar<workgroup> w: array<{element}, {count}>;\n\
         var<workgroup> v: f32;\n@compute @workgroup_size({x}, {y}, {z}) fn cs() {{\n    let a = &w[0];\n    v = 1.0;\n}}\n"
    )
}

fn flow(rng: &mut Random) -> String {
    let result = rng.one_in(2);
    let body = statements(
        rng,
        3,
        Around {
            result,
            ..Around::default()
        },
    );
    let (arrow, last) = if result {
        (" -> i32", rng.choose(&["", "    return 3;\n"]))
    } else {
        ("", "")
    };
    format!(
        "fn f(start: i32){arrow} {{\n    var x = start;\n{body}{last}}}\n\
         @compute @workgroup_size(1) fn cs() {{\n    {}f(1);\n}}\n",
        if result { "let r = " } else { "" }
    )
}

/// Surroundings of a statement, which decide what it may be.
#[derive(Clone, Copy, Default)]
struct Around {
    /// Whether its function gives a value.
    result: bool,
    may_break: bool,
    may_continue: bool,
    /// Whether it is in a continuing block, which may not leave its loop.
    continuing: bool,
}

fn statements(rng: &mut Random, depth: u32, around: Around) -> String {
    (0..rng.below(4))
        .map(|_| format!("{}\n", statement(rng, depth, around)))
        .collect()
}

fn statement(rng: &mut Random, depth: u32, around: Around) -> String {
    let simple = depth == 0 || rng.one_in(2);
    if simple {
        return match rng.below(6) {
            0 if around.may_break => "break;",
            1 if around.may_continue => "continue;",
            2 if !around.continuing => match around.result {
                true => "return 1;",
                false => "return;",
            },
            _ => "x += 1;",
        }
        .to_owned();
    }
    let depth = depth - 1;
    let turn = Around {
        may_break: true,
        may_continue: true,
        continuing: false,
        ..around
    };
    // A continuing block may have loops of its own, but not leave the function.
    let turn = if around.continuing {
        Around {
            continuing: true,
            ..turn
        }
    } else {
        turn
    };
    match rng.below(7) {
        0 => format!("{{\n{}}}", statements(rng, depth, around)),
        1 => format!("if x > 1 {{\n{}}}", statements(rng, depth, around)),
        2 => format!(
            "if x > 1 {{\n{}}} else {{\n{}}}",
            statements(rng, depth, around),
            statements(rng, depth, around)
        ),
        3 => {
            let inner = Around {
                may_break: !around.continuing || around.may_break,
                ..around
            };
            format!(
                "switch x {{\ncase 1, 2: {{\n{}}}\ndefault: {{\n{}}}\n}}",
                statements(rng, depth, inner),
                statements(rng, depth, inner)
            )
        }
        4 => {
            let condition = rng.choose(&["", "x < 3", "true"]);
            format!(
                "for (; {condition}; x++) {{\n{}}}",
                statements(rng, depth, turn)
            )
        }
        5 => format!("while x < 3 {{\n{}}}", statements(rng, depth, turn)),
        _ => {
            let continuing = match rng.below(3) {
                0 => {
                    let inner = Around {
                        result: around.result,
                        continuing: true,
                        may_break: false,
                        may_continue: false,
                    };
                    let last = rng.choose(&["", "break if x > 3;\n"]);
                    format!("continuing {{\n{}{last}}}\n", statements(rng, depth, inner))
                }
                _ => String::new(),
            };
            format!("loop {{\n{}{continuing}}}", statements(rng, depth, turn))
        }
    }
}

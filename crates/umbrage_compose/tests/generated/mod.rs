//! Random packages: axes with features, bindings, needs, and modules that read them, import each other and ask
//! interfaces.

use std::fmt::Write as _;

use proptest::prelude::*;
use umbrage_compose::{Key, Library, Package};

const FEATURES: usize = 5;
const MODULES: usize = 4;
const INTERFACES: usize = 2;
const IMPLEMENTATIONS: usize = 3;
const CAPABILITIES: usize = 2;
/// Modules below this number ask interfaces, and implementations call those from there on.
const ASKING: usize = 2;

/// Entry points of the root modules.
const ROOTS: [&str; 4] = [
    "@fragment fn main(@location(0) x: f32) -> @location(0) vec4f { return vec4f(call(x)); }",
    "@fragment fn main() -> @location(0) vec4f { return vec4f(call(2.0)); }",
    "@compute @workgroup_size(1) fn main() { _ = call(2.0); }",
    "@vertex fn main() -> @builtin(position) vec4f { return vec4f(call(2.0)); }",
];

const MORE: &str = "fn more(x: f32) -> f32 { return x + 1.0; }\n";

/// A value of an axis.
#[derive(Clone, Debug)]
struct Value {
    features: Vec<usize>,
    /// Capabilities that it provides or needs, as its axis does.
    capabilities: Vec<usize>,
}

/// A statement of a module's function.
#[derive(Clone, Debug)]
struct Statement {
    /// Features that must be on, or off.
    when: Vec<(usize, bool)>,
    what: What,
}

#[derive(Clone, Debug)]
enum What {
    Adds(u8),
    /// Calls a module with a higher number.
    Calls(usize),
    Asks(usize),
    /// Text with a fault, or one that is a fault in some company alone.
    Plants(Plant),
}

/// A statement that makes some permutations invalid.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Plant {
    /// A derivative: fragment stages alone have it, and it demands uniform control flow.
    Derivative,
    /// A derivative that is allowed in any control flow.
    LooseDerivative,
    /// Discards the fragment: fragment stages alone can.
    Discard,
    /// Control flow that depends on the value so far.
    Branch,
    /// Nine textures: a stage may have sixteen.
    Texture(usize),
    /// Writes to a buffer, which no vertex stage may do.
    Write,
    /// Notes a value in a private variable; where nothing recalls it, this is left out, derivative and all.
    Note(usize),
    /// Reads a private variable, whose value is not uniform.
    Recall(usize),
    /// A type error.
    Type,
}

/// A random package.
#[derive(Clone, Debug)]
pub(crate) struct Recipe {
    axes: Vec<(bool, Vec<Value>)>,
    roots: Vec<Vec<Statement>>,
    modules: Vec<Vec<Statement>>,
    implementations: Vec<Vec<Statement>>,
}

fn value() -> impl Strategy<Value = Value> {
    let features = prop::collection::vec(0..FEATURES, 0..3);
    let capabilities = prop::collection::vec(0..CAPABILITIES, 0..2);
    (features, capabilities).prop_map(|(features, capabilities)| Value {
        features,
        capabilities,
    })
}

fn body(plants: bool) -> impl Strategy<Value = Vec<Statement>> {
    let plant = prop_oneof![
        4 => Just(Plant::Derivative),
        4 => Just(Plant::LooseDerivative),
        4 => Just(Plant::Discard),
        4 => Just(Plant::Branch),
        4 => (0..3usize).prop_map(Plant::Texture),
        2 => Just(Plant::Write),
        4 => (0..2usize).prop_map(Plant::Note),
        2 => (0..2usize).prop_map(Plant::Recall),
        1 => Just(Plant::Type),
    ];
    let what = prop_oneof![
        2 => any::<u8>().prop_map(What::Adds),
        3 => (0..MODULES).prop_map(What::Calls),
        3 => (0..INTERFACES).prop_map(What::Asks),
        6 * u32::from(plants) => plant.prop_map(What::Plants),
    ];
    let when = prop::collection::vec((0..FEATURES, any::<bool>()), 0..2);
    let statement = (when, what).prop_map(|(when, what)| Statement { when, what });
    prop::collection::vec(statement, 1..4)
}

/// Random packages; with `plants`, such as have faults.
pub(crate) fn recipe(plants: bool) -> impl Strategy<Value = Recipe> {
    let axis = (any::<bool>(), prop::collection::vec(value(), 1..4));
    (
        prop::collection::vec(axis, 1..4),
        prop::collection::vec(body(plants), ROOTS.len()),
        prop::collection::vec(body(plants), MODULES),
        prop::collection::vec(body(plants), IMPLEMENTATIONS),
    )
        .prop_map(|(axes, roots, modules, implementations)| Recipe {
            axes,
            roots,
            modules,
            implementations,
        })
}

impl Recipe {
    /// The package as a library.
    pub(crate) fn library(&self) -> Library {
        let package = Package::from_sources("demo", "demo", self.files()).expect("a package");
        Library::new([package]).unwrap_or_else(|error| panic!("{error}"))
    }

    /// All legal keys, listed.
    pub(crate) fn keys(&self, library: &Library) -> Vec<Key> {
        let mut choices: Vec<Vec<(String, String)>> = vec![Vec::new()];
        for axis in library.axes().iter() {
            let longer = choices.iter().flat_map(|before| {
                axis.values().map(move |value| {
                    let mut choices = before.clone();
                    choices.push((axis.name.clone(), value.to_string()));
                    choices
                })
            });
            choices = longer.collect();
        }
        let keys = choices.iter().filter_map(|choices| {
            let choices = choices.iter().map(|(a, v)| (a.as_str(), v.as_str()));
            library.key(choices).ok()
        });
        keys.collect()
    }

    /// Files of the package.
    pub(crate) fn files(&self) -> Vec<(String, String)> {
        let mut files = vec![("axes.ron".to_owned(), self.axes())];
        for (index, statements) in self.roots.iter().enumerate() {
            let text = ROOTS[index];
            let body = function("call", &format!("r{index}"), 0, statements);
            files.push((format!("r{index}.wesl"), format!("{text}\n{body}")));
        }
        for (index, statements) in self.modules.iter().enumerate() {
            let body = function("call", &format!("m{index}"), index + 1, statements);
            files.push((format!("m{index}.wesl"), body));
        }
        for (index, statements) in self.implementations.iter().enumerate() {
            let body = function("ask", &format!("b{index}"), ASKING, statements);
            // The second interface has two functions, the last implementation one.
            let more = if index < 2 { MORE } else { "" };
            files.push((format!("b{index}.wesl"), body + more));
        }
        let notes = "var<private> note_0: f32;\nvar<private> note_1: f32;\n";
        files.push(("notes.wesl".to_owned(), notes.to_owned()));
        for index in 0..INTERFACES {
            let more = if index > 0 { MORE } else { "" };
            let text = format!("fn ask(x: f32) -> f32 {{ return x; }}\n{more}");
            files.push((format!("interface/i{index}.wesl"), text));
        }
        files
    }

    fn axes(&self) -> String {
        let mut used = [[false; 2]; CAPABILITIES];
        let of_axis = |axis: usize| axis % 2;
        for (axis, (_, values)) in self.axes.iter().enumerate() {
            for capability in values.iter().flat_map(|value| &value.capabilities) {
                used[*capability][of_axis(axis)] = true;
            }
        }
        let declared = |capability: usize| used[capability] == [true, true];
        let capabilities = (0..CAPABILITIES).filter(|c| declared(*c));
        let capabilities: String = capabilities.map(|c| format!("\"c{c}\": \"\", ")).collect();
        let mut axes = String::new();
        for (axis, (has_default, values)) in self.axes.iter().enumerate() {
            let default = if *has_default {
                "default: \"v0\", "
            } else {
                ""
            };
            let _ = write!(axes, "\"a{axis}\": ({default}values: {{ ");
            for (number, value) in values.iter().enumerate() {
                let names = value.features.iter().map(|f| format!("\"F{f}\""));
                let features = names.collect::<Vec<_>>().join(", ");
                let mut capabilities = value.capabilities.clone();
                capabilities.retain(|c| declared(*c));
                let names = capabilities.iter().map(|c| format!("\"c{c}\""));
                let names = names.collect::<Vec<_>>().join(", ");
                let list = ["provides", "needs"][of_axis(axis)];
                let _ = write!(
                    axes,
                    "\"v{number}\": (features: [{features}], {list}: [{names}]), "
                );
            }
            axes.push_str("}), ");
        }
        let bind = |interface: usize, to: &str| {
            format!("bind: {{ \"package::interface::i{interface}\": \"package::{to}\" }}")
        };
        for interface in 0..INTERFACES {
            let _ = write!(axes, "\"i{interface}\": (default: \"own\", values: {{ ");
            let own = bind(interface, &format!("interface::i{interface}"));
            let _ = write!(axes, "\"own\": ({own}), ");
            for index in 0..IMPLEMENTATIONS {
                let bound = bind(interface, &format!("b{index}"));
                let _ = write!(axes, "\"b{index}\": ({bound}), ");
            }
            axes.push_str("}), ");
        }
        let roots: String = (0..self.roots.len())
            .map(|index| format!("\"r{index}\": (root: \"package::r{index}\"), "))
            .collect();
        let all: String = (0..FEATURES).map(|f| format!("\"F{f}\", ")).collect();
        format!(
            "(capabilities: {{ {capabilities} }}, axes: {{ {axes} \"root\": (values: {{ {roots} }}), \"z\": (default: \"off\", values: {{ \"off\": (), \"all\": (features: [{all}]) }}) }})"
        )
    }
}

/// A function `name` of the module `module`, with the declarations that it uses. It calls modules from `above` on.
fn function(name: &str, module: &str, above: usize, statements: &[Statement]) -> String {
    let (mut text, mut body) = (String::new(), String::new());
    for (index, statement) in statements.iter().enumerate() {
        let features = statement.when.iter().map(|(feature, on)| {
            let not = if *on { "" } else { "!" };
            format!("{not}F{feature}")
        });
        let when = match features.collect::<Vec<_>>().join(" && ") {
            none if none.is_empty() => String::new(),
            some => format!("@if({some}) "),
        };
        let line = match &statement.what {
            What::Adds(number) => format!("{{ y += {number}.0; }}"),
            // Nothing goes in a circle.
            What::Asks(_) if above > ASKING || name == "ask" => "{ y *= 3.0; }".to_owned(),
            What::Calls(other) if *other < above => "{ y *= 2.0; }".to_owned(),
            What::Calls(other) => format!("{{ y += package::m{other}::call(y); }}"),
            What::Asks(interface) => {
                format!("{{ y += package::interface::i{interface}::ask(y); }}")
            }
            What::Plants(Plant::Derivative) => "{ y += dpdx(x); }".to_owned(),
            What::Plants(Plant::LooseDerivative) => {
                "@diagnostic(off, derivative_uniformity) { y += dpdx(x); }".to_owned()
            }
            What::Plants(Plant::Discard) => "if y > 9.0 { discard; }".to_owned(),
            What::Plants(Plant::Branch) => "if y > 1.0 { return y; }".to_owned(),
            What::Plants(Plant::Note(number)) => {
                format!("{{ package::notes::note_{number} = dpdx(x); }}")
            }
            What::Plants(Plant::Recall(number)) => {
                format!("{{ y += package::notes::note_{number}; }}")
            }
            What::Plants(Plant::Texture(number)) => {
                let name = format!("{module}_texture_{number}_{index}");
                // A stage may have 16 of them.
                for n in 0..9 {
                    let _ = writeln!(
                        text,
                        "{when}@group(0) @binding(0) var {name}_{n}: texture_2d<f32>;"
                    );
                }
                let loads = (0..9).map(|n| format!("textureLoad({name}_{n}, vec2u(), 0).x"));
                format!("{{ y += {}; }}", loads.collect::<Vec<_>>().join(" + "))
            }
            What::Plants(Plant::Write) => {
                let name = format!("{module}_buffer_{index}");
                let _ = writeln!(
                    text,
                    "{when}@group(0) @binding(0) var<storage, read_write> {name}: array<f32>;"
                );
                format!("{{ {name}[0] = y; }}")
            }
            What::Plants(Plant::Type) => "{ y += true; }".to_owned(),
        };
        let _ = writeln!(body, "    {when}{line}");
    }
    format!("{text}fn {name}(x: f32) -> f32 {{\n    var y = x;\n{body}    return y;\n}}\n")
}

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

/// A statement that may make a permutation invalid.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Plant {
    /// A derivative, which a compute stage does not have, and which demands uniform control flow.
    Derivative,
    /// Control flow that depends on an input.
    Branch,
    /// A texture of the module's own: a stage may have only so many.
    Texture(usize),
    /// A write to a buffer of the module's own, which no vertex stage may do.
    Write,
    /// A type error.
    Type,
}

/// A random package.
#[derive(Clone, Debug)]
pub(crate) struct Recipe {
    axes: Vec<(bool, Vec<Value>)>,
    roots: Vec<Vec<Statement>>,
    stages: Vec<u8>,
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
        Just(Plant::Derivative),
        Just(Plant::Branch),
        (0..3usize).prop_map(Plant::Texture),
        Just(Plant::Write),
        Just(Plant::Type),
    ];
    let what = prop_oneof![
        3 => any::<u8>().prop_map(What::Adds),
        3 => (0..MODULES).prop_map(What::Calls),
        2 => (0..INTERFACES).prop_map(What::Asks),
        u32::from(plants) => plant.prop_map(What::Plants),
    ];
    let when = prop::collection::vec((0..FEATURES, any::<bool>()), 0..3);
    let statement = (when, what).prop_map(|(when, what)| Statement { when, what });
    prop::collection::vec(statement, 0..4)
}

/// Random packages; with `plants`, such as have faults.
pub(crate) fn recipe(plants: bool) -> impl Strategy<Value = Recipe> {
    let axis = (any::<bool>(), prop::collection::vec(value(), 1..4));
    (
        prop::collection::vec(axis, 1..5),
        prop::collection::vec(body(plants), 1..3),
        prop::collection::vec(0..3u8, 3),
        prop::collection::vec(body(plants), MODULES),
        prop::collection::vec(body(plants), IMPLEMENTATIONS),
    )
        .prop_map(|(axes, roots, stages, modules, implementations)| Recipe {
            axes,
            roots,
            stages,
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
            let text = match self.stages[index] {
                0 => {
                    "@fragment fn main(@location(0) x: f32) -> @location(0) vec4f { return vec4f(call(x)); }"
                }
                1 => {
                    "@compute @workgroup_size(1) fn main(@builtin(local_invocation_index) x: u32) { _ = call(f32(x)); }"
                }
                _ => {
                    "@vertex fn main(@location(0) x: f32) -> @builtin(position) vec4f { return vec4f(call(x)); }"
                }
            };
            let body = function("call", &format!("r{index}"), 0, statements);
            files.push((format!("r{index}.wesl"), format!("{text}\n{body}")));
        }
        for (index, statements) in self.modules.iter().enumerate() {
            let body = function("call", &format!("m{index}"), index + 1, statements);
            files.push((format!("m{index}.wesl"), body));
        }
        for (index, statements) in self.implementations.iter().enumerate() {
            // Implementations call modules, but ask no interface: nothing goes in a circle.
            let asks = |statement: &&Statement| !matches!(statement.what, What::Asks(_));
            let statements: Vec<_> = statements.iter().filter(asks).cloned().collect();
            let body = function("ask", &format!("b{index}"), 0, &statements);
            files.push((format!("b{index}.wesl"), body));
        }
        for index in 0..INTERFACES {
            let text = "fn ask(x: f32) -> f32 { return x; }".to_owned();
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
            What::Calls(other) if *other < above => "{ y *= 2.0; }".to_owned(),
            What::Calls(other) => format!("{{ y += package::m{other}::call(y); }}"),
            What::Asks(interface) => {
                format!("{{ y += package::interface::i{interface}::ask(y); }}")
            }
            What::Plants(Plant::Derivative) => "{ y += dpdx(x); }".to_owned(),
            What::Plants(Plant::Branch) => "if x > 1.0 { return y; }".to_owned(),
            What::Plants(Plant::Texture(number)) => {
                let name = format!("{module}_texture_{number}_{index}");
                // Eight of them are over the limit of a stage.
                for n in 0..8 {
                    let _ = writeln!(
                        text,
                        "{when}@group(0) @binding(auto) var {name}_{n}: texture_2d<f32>;"
                    );
                }
                let loads = (0..8).map(|n| format!("textureLoad({name}_{n}, vec2u(), 0).x"));
                format!("{{ y += {}; }}", loads.collect::<Vec<_>>().join(" + "))
            }
            What::Plants(Plant::Write) => {
                let name = format!("{module}_buffer_{index}");
                let _ = writeln!(
                    text,
                    "{when}@group(0) @binding(auto) var<storage, read_write> {name}: array<f32>;"
                );
                format!("{{ {name}[0] = y; }}")
            }
            What::Plants(Plant::Type) => "{ y += true; }".to_owned(),
        };
        let _ = writeln!(body, "    {when}{line}");
    }
    format!("{text}fn {name}(x: f32) -> f32 {{\n    var y = x;\n{body}    return y;\n}}\n")
}

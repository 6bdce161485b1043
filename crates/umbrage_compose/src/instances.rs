//! Implementations that would share state.
//!
//! A shader contains a module once, however many modules import it and under whatever names, so all of them share
//! its resources. Two implementations of one interface, called side by side, are meant to be independent, each with
//! resources of its own that the host makes. Where something below both of them declares a resource, both read the
//! same one, and the value that the host sets last for one is wrong for the other. So that is a fault. So are two
//! of their resources that a host which binds by name cannot tell apart, and one function with resources that a
//! module calls by two names.
//!
//! Three things are allowed: an implementation that is part of another (called by it alone); a resource that the
//! rest of the shader uses too (such as the pass's frame, which is meant to be shared); and implementations without
//! resources of their own, which only ask what is bound to other interfaces.

use std::collections::{BTreeMap, BTreeSet};

use naga::{AddressSpace, Expression, Function, GlobalVariable, Handle, Module};
use rustc_hash::FxHashMap;

use crate::{
    Cause, Fault, Library, error::Place, fetches::callees, names::Item, reach::FunctionId,
    stubs::JOINT,
};

/// A call as its author wrote it.
pub(crate) struct Call {
    /// The calling module.
    pub(crate) module: usize,
    /// Name by which it calls the function.
    pub(crate) name: String,
    /// First part of that name, where the calling module chose it itself.
    pub(crate) alias: Option<String>,
    /// Whether the call goes through an interface.
    pub(crate) by_interface: bool,
    pub(crate) target: FunctionId,
}

/// A linked module, and the declarations that its parts came from.
pub(crate) struct Origins<'a> {
    pub(crate) library: &'a Library,
    pub(crate) root: usize,
    pub(crate) module: &'a Module,
    /// By the functions' indices.
    pub(crate) functions: &'a [FunctionId],
    /// Names of the functions as their authors wrote them, by the functions' indices.
    pub(crate) names: &'a [&'a str],
    /// By the variables' indices.
    pub(crate) variables: &'a [Item],
    /// The calls from module to module, in a fixed order.
    pub(crate) calls: &'a [Call],
}

/// Checks that no two implementations of an interface share state without saying so.
pub(crate) fn check(origins: &Origins<'_>) -> Result<(), Fault> {
    let implementations = implementations(origins)?;
    let twice = called_by_two_names(origins);
    let several = implementations.values().any(|modules| modules.len() > 1);
    if !several && twice.is_empty() {
        return Ok(());
    }
    let graph = Graph::new(origins);
    for (first, second) in twice {
        graph.check_names(first, second)?;
    }
    for (interface, modules) in &implementations {
        let modules: Vec<_> = modules.iter().collect();
        for (index, a) in modules.iter().enumerate() {
            for b in &modules[index + 1..] {
                graph.check_pair(*interface, *a, *b)?;
            }
        }
    }
    Ok(())
}

/// The functions that implement an interface, by their modules.
type Implementations = BTreeMap<usize, BTreeMap<usize, BTreeSet<Handle<Function>>>>;

/// The linked modules that implement every function of an interface, and these functions.
fn implementations(origins: &Origins<'_>) -> Result<Implementations, Fault> {
    let library = origins.library;
    let mut linked: FxHashMap<&str, Vec<(usize, Handle<Function>)>> = FxHashMap::default();
    let functions = origins.module.functions.iter().zip(origins.functions);
    for (((handle, _), id), name) in functions.zip(origins.names) {
        linked.entry(name).or_default().push((id.0, handle));
    }
    let mut found = Implementations::new();
    for &interface in library.interfaces() {
        // No linked module has an interface that does not parse.
        let Ok(contract) = library.syntax(interface) else {
            continue;
        };
        let named = contract.functions.iter();
        let named = named.filter_map(|name| linked.get(name.as_str())).flatten();
        let mut modules: BTreeMap<usize, BTreeSet<_>> = BTreeMap::new();
        for (module, handle) in named {
            modules.entry(*module).or_default().insert(*handle);
        }
        if modules.len() < 2 {
            continue;
        }
        for (module, functions) in modules {
            let declared = &library.syntax(module)?.functions;
            if contract.functions.is_subset(declared) {
                found
                    .entry(interface)
                    .or_default()
                    .insert(module, functions);
            }
        }
    }
    Ok(found)
}

/// Pairs of calls in one module that call one function of another by two names.
fn called_by_two_names<'a>(origins: &Origins<'a>) -> Vec<(&'a Call, &'a Call)> {
    let linked: BTreeSet<_> = origins.functions.iter().collect();
    let mut first: BTreeMap<(usize, FunctionId), &Call> = BTreeMap::new();
    let mut twice = Vec::new();
    for call in origins.calls {
        if !linked.contains(&call.target) {
            continue;
        }
        let known = first.entry((call.module, call.target)).or_insert(call);
        if known.alias != call.alias {
            twice.push((*known, call));
        }
    }
    twice
}

/// Name that the caller itself chose for `item` or for its module, in the call `name`; none where the call uses
/// their own names.
pub(crate) fn alias(library: &Library, name: &str, item: &Item) -> Option<String> {
    if name == item.name {
        return None;
    }
    let parts: Vec<_> = name.split(JOINT).collect();
    let own = match *parts.as_slice() {
        [_] => Some(item.name.as_str()),
        ["package" | "super" | "self", ..] => return None,
        // The first part is the name of an imported module or of a package.
        _ => {
            let path = &library.source(item.module).path;
            path.rsplit("::").nth(parts.len() - 2)
        }
    };
    (own != Some(parts[0])).then(|| parts[0].to_owned())
}

/// The called function's name, as the caller wrote it.
fn written(call: &Call) -> String {
    call.name.replace(JOINT, "::")
}

/// Call graph of a linked module, with the resources that each function uses. Entry points are functions without a
/// handle.
struct Graph<'a> {
    origins: &'a Origins<'a>,
    nodes: Vec<Node>,
    by_handle: FxHashMap<Handle<Function>, usize>,
}

struct Node {
    module: usize,
    callees: BTreeSet<Handle<Function>>,
    resources: BTreeSet<Handle<GlobalVariable>>,
}

type Nodes = BTreeSet<usize>;
type Resources = BTreeSet<Handle<GlobalVariable>>;

impl<'a> Graph<'a> {
    fn new(origins: &'a Origins<'a>) -> Self {
        let module = origins.module;
        let is_resource = |variable: Handle<GlobalVariable>| {
            matches!(
                module.global_variables[variable].space,
                AddressSpace::Uniform | AddressSpace::Storage { .. } | AddressSpace::Handle
            )
        };
        let node = |home: usize, function: &Function| Node {
            module: home,
            callees: callees(function).into_iter().collect(),
            resources: function
                .expressions
                .iter()
                .filter_map(|(_, expression)| match expression {
                    Expression::GlobalVariable(variable) => Some(*variable),
                    _ => None,
                })
                .filter(|variable| is_resource(*variable))
                .collect(),
        };
        let mut nodes = Vec::new();
        let mut by_handle = FxHashMap::default();
        for (handle, function) in module.functions.iter() {
            let home = origins.functions.get(handle.index());
            by_handle.insert(handle, nodes.len());
            nodes.push(node(home.map_or(origins.root, |id| id.0), function));
        }
        for entry in &module.entry_points {
            nodes.push(node(origins.root, &entry.function));
        }
        Self {
            origins,
            nodes,
            by_handle,
        }
    }

    fn check_names(&self, first: &Call, second: &Call) -> Result<(), Fault> {
        let handles = self.origins.module.functions.iter();
        let function = handles.map(|(handle, _)| handle);
        let function =
            function.filter(|h| self.origins.functions.get(h.index()) == Some(&first.target));
        let reached = self.reached(&function.collect(), false);
        let outside = self.resources(|node| !reached.contains(&node));
        let inside = self.resources(|node| reached.contains(&node));
        let Some(shared) = inside.difference(&outside).next() else {
            return Ok(());
        };
        let path = &self.origins.library.source(first.target.0).path;
        let message = format!(
            "`{}` and `{}` are one function of `{path}`, with one `{}` between them",
            written(first),
            written(second),
            self.name(*shared)
        );
        Err(self
            .fault(message, [self.call(first, ""), self.call(second, "the same")], *shared)
            .note("a module is in a shader once, by however many names: call it by one; to have two with resources of their own, make a second module with resources of other names"))
    }

    fn check_pair(
        &self,
        interface: usize,
        (a, parts_of_a): (&usize, &BTreeSet<Handle<Function>>),
        (b, parts_of_b): (&usize, &BTreeSet<Handle<Function>>),
    ) -> Result<(), Fault> {
        let (in_a, in_b) = (
            self.reached(parts_of_a, false),
            self.reached(parts_of_b, false),
        );
        if !self.is_called_outside(*a, parts_of_a, &in_a, &in_b)
            || !self.is_called_outside(*b, parts_of_b, &in_b, &in_a)
        {
            return Ok(());
        }
        let open = self.resources(|node| !in_a.contains(&node) && !in_b.contains(&node));
        let state = |nodes: &Nodes| -> Resources {
            let all = self.resources(|node| nodes.contains(&node));
            all.difference(&open).copied().collect()
        };
        let owns = |parts| !state(&self.reached(parts, true)).is_empty();
        let (of_a, of_b) = (state(&in_a), state(&in_b));
        let library = self.origins.library;
        let path = |module: usize| &library.source(module).path;
        let calls = || {
            let contract = format!("implements `{}`", path(interface));
            [
                self.entry(*a, parts_of_a, &contract),
                self.entry(*b, parts_of_b, "so does this"),
            ]
        };
        if let Some(shared) = of_a.intersection(&of_b).next()
            && owns(parts_of_a)
            && owns(parts_of_b)
        {
            let message = format!(
                "`{}` and `{}` would share one `{}`",
                path(*a),
                path(*b),
                self.name(*shared)
            );
            return Err(self.fault(message, calls(), *shared).note(
                "a module is in a shader once, and so are its resources, though the host makes them for one implementation at a time: call one of the two here, or give each resources of its own, in modules that the other does not reach",
            ));
        }
        let group = |variable: Handle<GlobalVariable>| {
            let binding = self.origins.module.global_variables[variable].binding;
            binding.map(|binding| binding.group)
        };
        for one in of_a.difference(&of_b) {
            let alike = |other: &&Handle<GlobalVariable>| {
                self.name(*one) == self.name(**other) && group(*one) == group(**other)
            };
            if let Some(other) = of_b.difference(&of_a).find(alike) {
                let message = format!(
                    "`{}` and `{}` each have a `{}` in group {}, and a host that binds by names gives both the same",
                    path(*a),
                    path(*b),
                    self.name(*one),
                    group(*one).unwrap_or_default()
                );
                let fault = self.fault(message, calls(), *one);
                let fault = match self.place(*other, "and this") {
                    Some(place) => fault.at(place),
                    None => fault,
                };
                return Err(fault.note("rename one of them, or call one of the two here"));
            }
        }
        Ok(())
    }

    /// Functions that `parts` call, directly or not, and `parts` themselves; with `alone`, without following calls
    /// through other interfaces.
    fn reached(&self, parts: &BTreeSet<Handle<Function>>, alone: bool) -> Nodes {
        let mut reached = Nodes::new();
        let mut waiting: Vec<_> = parts.iter().map(|handle| self.by_handle[handle]).collect();
        while let Some(node) = waiting.pop() {
            if !reached.insert(node) {
                continue;
            }
            let Node {
                module, callees, ..
            } = &self.nodes[node];
            let callees = callees
                .iter()
                .filter(|callee| !alone || !self.is_by_interface(*module, **callee));
            waiting.extend(callees.map(|callee| self.by_handle[callee]));
        }
        reached
    }

    fn is_by_interface(&self, module: usize, callee: Handle<Function>) -> bool {
        let target = self.origins.functions.get(callee.index());
        let mut calls = self.origins.calls.iter();
        calls.any(|call| call.by_interface && call.module == module && Some(&call.target) == target)
    }

    fn resources(&self, of: impl Fn(usize) -> bool) -> Resources {
        let nodes = self.nodes.iter().enumerate().filter(|(node, _)| of(*node));
        nodes
            .flat_map(|(_, node)| node.resources.iter().copied())
            .collect()
    }

    /// Whether any function calls `parts` apart from themselves and the `other` implementation.
    fn is_called_outside(
        &self,
        module: usize,
        parts: &BTreeSet<Handle<Function>>,
        own: &Nodes,
        other: &Nodes,
    ) -> bool {
        let mut nodes = self.nodes.iter().enumerate();
        module == self.origins.root
            || nodes.any(|(index, node)| {
                !own.contains(&index) && !other.contains(&index) && !node.callees.is_disjoint(parts)
            })
    }

    fn fault<'p>(
        &self,
        message: String,
        calls: impl IntoIterator<Item = Place<'p>>,
        shared: Handle<GlobalVariable>,
    ) -> Fault {
        let mut fault = Fault::new(Cause::Interface, message);
        for place in calls {
            fault = fault.at(place);
        }
        match self.place(shared, "the resource") {
            Some(place) => fault.at(place),
            None => fault,
        }
    }

    fn name(&self, variable: Handle<GlobalVariable>) -> &str {
        let item = self.origins.variables.get(variable.index());
        item.map_or("", |item| item.name.as_str())
    }

    fn place(&self, variable: Handle<GlobalVariable>, label: &str) -> Option<Place<'a>> {
        let library = self.origins.library;
        let span = self.origins.module.global_variables.get_span(variable);
        let range = span.to_range()?;
        let (module, start) = library.locate(range.start)?;
        let source = library.source(module);
        Some(source.place_labelled(start..start + range.len(), label))
    }

    /// Place where another module calls one of the `parts` of `module`; the start of `module` where none does.
    fn entry(&self, module: usize, parts: &BTreeSet<Handle<Function>>, label: &str) -> Place<'a> {
        let targets: Vec<_> = parts
            .iter()
            .filter_map(|handle| self.origins.functions.get(handle.index()))
            .collect();
        let mut calls = self.origins.calls.iter();
        let call = calls.find(|call| targets.contains(&&call.target));
        match call {
            Some(call) => self.call(call, label),
            None => self
                .origins
                .library
                .source(module)
                .place_labelled(0..0, label),
        }
    }

    fn call(&self, call: &Call, label: &str) -> Place<'a> {
        let source = self.origins.library.source(call.module);
        let mut place = source.find(&written(call));
        place.label = label.to_owned();
        place
    }
}

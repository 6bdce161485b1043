//! Random shaders that ask for uniform control flow in all kinds of control flow, some rightly. A shader follows from
//! its number alone.

use std::fmt::Write as _;

/// The shader of the number `seed`.
pub fn random_shader(seed: u64) -> String {
    let mut random = Random::new(seed);
    let fragment = random.one_in(2);
    let mut maker = Maker {
        fragment,
        // Half of the shaders have few values that differ between invocations.
        differs: if random.one_in(2) { 3 } else { 12 },
        filters: fragment && random.one_in(4),
        random,
        names: 0,
        functions: Vec::new(),
        text: String::new(),
    };
    maker.module();
    maker.text
}

/// Numbers without a pattern that are the same in every version, as stored verdicts ask: SplitMix64.
#[derive(Debug)]
pub struct Random(u64);

impl Random {
    /// The numbers that follow from `seed`.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// A number from 0 to below `end`.
    pub fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((bits ^ (bits >> 31)) % end.max(1) as u64) as usize
    }

    /// Whether a chance of one in `many` came true.
    pub fn one_in(&mut self, many: usize) -> bool {
        self.below(many) == 0
    }

    /// One of `from`, which has one at the least.
    pub fn choose<'a>(&mut self, from: &[&'a str]) -> &'a str {
        from[self.below(from.len())]
    }
}

/// Kind of a function's parameter.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Value,
    Pointer,
    ArrayPointer,
}

#[derive(Clone)]
struct Function {
    name: String,
    parameters: Vec<Kind>,
    gives: bool,
}

/// Names in scope, and the statements that may stand there.
#[derive(Clone, Default)]
struct Scope {
    /// Expressions that may be read.
    values: Vec<String>,
    /// Variables that are numbers.
    variables: Vec<String>,
    arrays: Vec<String>,
    pointers: Vec<String>,
    array_pointers: Vec<String>,
    /// How deep statements may still nest.
    depth: usize,
    in_loop: bool,
    in_switch: bool,
    /// Whether a `return` may stand here, and with a value.
    returns: Option<bool>,
}

struct Maker {
    random: Random,
    fragment: bool,
    /// One in so many values differs between invocations.
    differs: usize,
    filters: bool,
    names: usize,
    functions: Vec<Function>,
    text: String,
}

impl Maker {
    fn module(&mut self) {
        self.text += "@group(0) @binding(0) var<storage> same_values: array<i32>;\n\
             @group(0) @binding(1) var<uniform> same: vec4i;\nvar<private> own: i32;\n";
        self.text += match self.fragment {
            true => {
                "@group(0) @binding(2) var image: texture_2d<f32>;\n\
                 @group(0) @binding(3) var at_rest: sampler;\n"
            }
            false => {
                "@group(0) @binding(2) var<storage, read_write> shared_values: array<i32>;\n\
                 var<workgroup> room: array<i32, 4>;\n"
            }
        };
        for _ in 0..self.random.below(4) {
            self.function();
        }
        let mut scope = Scope {
            depth: 3,
            returns: (!self.fragment).then_some(false),
            ..Scope::default()
        };
        let differs = self.random.one_in(self.differs);
        let head = match self.fragment {
            true => "@fragment fn fs(@location(0) x: f32) {\n",
            false => {
                scope.values.push("i32(group.x)".to_owned());
                "@compute @workgroup_size(64) fn cs(@builtin(workgroup_id) group: vec3u, \
                 @builtin(local_invocation_id) local: vec3u) {\n"
            }
        };
        if differs {
            let input = if self.fragment {
                "i32(x)"
            } else {
                "i32(local.x)"
            };
            scope.values.push(input.to_owned());
        }
        self.text += head;
        let statements = 2 + self.random.below(6);
        let body = self.statements(&mut scope, statements);
        let _ = writeln!(self.text, "{body}}}");
    }

    fn function(&mut self) {
        let mut scope = Scope {
            depth: 2,
            ..Scope::default()
        };
        let mut kinds = Vec::new();
        let mut parameters = Vec::new();
        for _ in 0..self.random.below(4) {
            let name = self.name('p');
            let (kind, ty) = match self.random.below(4) {
                0 => (Kind::Pointer, "ptr<function, i32>"),
                1 => (Kind::ArrayPointer, "ptr<function, array<i32, 4>>"),
                _ => (Kind::Value, "i32"),
            };
            parameters.push(format!("{name}: {ty}"));
            kinds.push(kind);
            match kind {
                Kind::Value => scope.values.push(name),
                Kind::Pointer => scope.pointers.push(name),
                Kind::ArrayPointer => scope.array_pointers.push(name),
            }
        }
        let gives = !self.random.one_in(3);
        scope.returns = Some(gives);
        let name = self.name('f');
        let filter = self.filter();
        let statements = 1 + self.random.below(4);
        let mut body = self.statements(&mut scope, statements);
        if gives && !ends(&body) {
            let _ = writeln!(body, "return {};", self.value(&scope, 1));
        }
        let (parameters, arrow) = (parameters.join(", "), if gives { " -> i32" } else { "" });
        let _ = writeln!(
            self.text,
            "{filter}fn {name}({parameters}){arrow} {{\n{body}}}"
        );
        self.functions.push(Function {
            name,
            parameters: kinds,
            gives,
        });
    }

    /// Statements in a scope of their own.
    fn block(&mut self, scope: &Scope) -> String {
        let mut inner = scope.clone();
        inner.depth = scope.depth.saturating_sub(1);
        let statements = 1 + self.random.below(3);
        let body = self.statements(&mut inner, statements);
        format!("{{\n{body}}}")
    }

    fn statements(&mut self, scope: &mut Scope, count: usize) -> String {
        let mut out = String::new();
        for _ in 0..count {
            let statement = self.statement(scope);
            out += &statement;
            out.push('\n');
            if ends(&out) {
                break;
            }
        }
        out
    }

    fn statement(&mut self, scope: &mut Scope) -> String {
        match self.random.below(if scope.depth > 0 { 30 } else { 20 }) {
            0 | 1 if scope.in_loop || scope.in_switch => {
                let goes_on = scope.in_loop && self.random.one_in(2);
                let word = if goes_on { "continue;" } else { "break;" };
                word.to_owned()
            }
            2 if scope.returns == Some(true) => format!("return {};", self.value(scope, 1)),
            2 if scope.returns == Some(false) => "return;".to_owned(),
            3 if self.fragment && scope.returns.is_none() && !scope.in_loop => {
                format!("if {} {{\ndiscard;\n}}", self.condition(scope, 1))
            }
            4..=6 => self.demand(),
            7 | 8 => {
                let name = self.name('v');
                let value = self.value(scope, 2);
                scope.values.push(name.clone());
                scope.variables.push(name.clone());
                match self.random.below(3) {
                    0 => format!("var {name}: i32;"),
                    _ => format!("var {name} = {value};"),
                }
            }
            9 => {
                let name = self.name('l');
                let value = self.value(scope, 2);
                scope.values.push(name.clone());
                format!("let {name} = {value};")
            }
            10 => {
                let name = self.name('a');
                scope.arrays.push(name.clone());
                format!("var {name}: array<i32, 4>;")
            }
            11 => {
                let mut places: Vec<_> = scope.variables.iter().map(|v| format!("&{v}")).collect();
                for array in &scope.arrays {
                    places.push(format!("&{array}[{}]", self.value(scope, 0)));
                }
                if places.is_empty() {
                    return self.demand();
                }
                let name = self.name('q');
                let place = places.swap_remove(self.random.below(places.len()));
                scope.pointers.push(name.clone());
                format!("let {name} = {place};")
            }
            12 | 13 => {
                let count = self.functions.len();
                let called = (count > 0).then(|| self.functions[self.random.below(count)].clone());
                let call =
                    called.and_then(|called| Some((self.call(scope, &called)?, called.gives)));
                match call {
                    Some((call, true)) => format!("_ = {call};"),
                    Some((call, false)) => format!("{call};"),
                    None => self.demand(),
                }
            }
            0..20 => self.assignment(scope),
            20..24 => {
                let (filter, condition) = (self.filter(), self.condition(scope, 1));
                let (inner, accept) = (self.filter(), self.block(scope));
                let mut out = format!("{filter}if {condition} {inner}{accept}");
                if self.random.one_in(3) {
                    let (condition, other) = (self.condition(scope, 1), self.block(scope));
                    let _ = write!(out, " else if {condition} {other}");
                }
                if self.random.one_in(2) {
                    let (filter, reject) = (self.filter(), self.block(scope));
                    let _ = write!(out, " else {filter}{reject}");
                }
                out
            }
            24 | 25 => {
                let (name, begin) = (self.name('i'), self.value(scope, 1));
                let mut inner = Scope {
                    in_loop: true,
                    in_switch: false,
                    ..scope.clone()
                };
                inner.values.push(name.clone());
                inner.variables.push(name.clone());
                let (filter, condition) = (self.filter(), self.condition(&inner, 0));
                let body = self.block(&inner);
                format!("{filter}for (var {name} = {begin}; {condition}; {name}++) {body}")
            }
            26 => {
                let (filter, condition) = (self.filter(), self.condition(scope, 1));
                let inner = Scope {
                    in_loop: true,
                    in_switch: false,
                    ..scope.clone()
                };
                format!("{filter}while {condition} {}", self.block(&inner))
            }
            27 => self.repeat(scope),
            28 => {
                let (filter, selector) = (self.filter(), self.value(scope, 1));
                let inner = Scope {
                    in_switch: true,
                    ..scope.clone()
                };
                let (one, other) = (self.block(&inner), self.block(&inner));
                format!("{filter}switch {selector} {{\ncase 0, 1: {one}\ndefault: {other}\n}}")
            }
            _ => format!("{}{}", self.filter(), self.block(scope)),
        }
    }

    fn repeat(&mut self, scope: &Scope) -> String {
        let filter = self.filter();
        let mut inner = Scope {
            in_loop: true,
            in_switch: false,
            depth: scope.depth - 1,
            ..scope.clone()
        };
        let statements = 1 + self.random.below(3);
        let mut body = self.statements(&mut inner, statements);
        // A loop without an exit is an error of another kind.
        if ends(&body) {
            body = format!("if {} {{\nbreak;\n}}\n{body}", self.condition(scope, 1));
        }
        let mut after = Scope {
            in_loop: false,
            in_switch: false,
            depth: 0,
            returns: None,
            ..scope.clone()
        };
        let continuing = self.statements(&mut after, 2);
        let condition = self.condition(scope, 1);
        format!("{filter}loop {{\n{body}continuing {{\n{continuing}break if {condition};\n}}\n}}")
    }

    fn assignment(&mut self, scope: &Scope) -> String {
        let mut places = scope.variables.clone();
        places.extend(scope.pointers.iter().map(|pointer| format!("*{pointer}")));
        for array in &scope.arrays {
            places.push(format!("{array}[{}]", self.value(scope, 0)));
        }
        for pointer in &scope.array_pointers {
            places.push(format!("(*{pointer})[{}]", self.value(scope, 0)));
        }
        let wholes = scope.arrays.iter().cloned();
        let wholes = wholes.chain(scope.array_pointers.iter().map(|p| format!("*{p}")));
        let wholes: Vec<_> = wholes.collect();
        if !wholes.is_empty() && self.random.one_in(5) {
            return format!(
                "{} = array<i32, 4>();",
                wholes[self.random.below(wholes.len())]
            );
        }
        if places.is_empty() {
            return format!("own = {};", self.value(scope, 1));
        }
        let place = places.swap_remove(self.random.below(places.len()));
        match self.random.below(4) {
            0 => format!("{place}++;"),
            1 => format!("{place} += {};", self.value(scope, 1)),
            _ => format!("{place} = {};", self.value(scope, 2)),
        }
    }

    /// A call that wants uniform control flow.
    fn demand(&mut self) -> String {
        let call = match self.fragment {
            true => self.random.choose(&[
                "_ = dpdx(1.0);",
                "_ = fwidthFine(2.0);",
                "_ = textureSample(image, at_rest, vec2f());",
                "_ = textureSampleBias(image, at_rest, vec2f(), 1.0);",
            ]),
            false => self
                .random
                .choose(&["workgroupBarrier();", "storageBarrier();"]),
        };
        call.to_owned()
    }

    fn filter(&mut self) -> String {
        if !self.filters || !self.random.one_in(3) {
            return String::new();
        }
        let severity = self.random.choose(&["off", "info", "warning", "error"]);
        format!("@diagnostic({severity}, derivative_uniformity) ")
    }

    fn condition(&mut self, scope: &Scope, depth: usize) -> String {
        if depth > 0 && self.random.one_in(5) {
            let (left, right) = (
                self.condition(scope, depth - 1),
                self.condition(scope, depth - 1),
            );
            return format!("({left} {} {right})", self.random.choose(&["&&", "||"]));
        }
        let (left, right) = (self.value(scope, depth), self.value(scope, depth));
        format!("({left} {} {right})", self.random.choose(&["<", ">", "=="]))
    }

    /// A numeric expression, nested at most `depth` deep.
    fn value(&mut self, scope: &Scope, depth: usize) -> String {
        let compound = if depth > 0 { self.random.below(12) } else { 12 };
        match compound {
            0 | 1 => {
                let (left, right) = (self.value(scope, depth - 1), self.value(scope, depth - 1));
                format!("({left} {} {right})", self.random.choose(&["+", "-", "*"]))
            }
            2 => {
                let (no, yes) = (self.value(scope, depth - 1), self.value(scope, depth - 1));
                let condition = self.condition(scope, depth - 1);
                format!("select({no}, {yes}, {condition})")
            }
            3 if self.fragment => format!("i32(dpdx(f32({})))", self.value(scope, depth - 1)),
            3 => match self.random.below(3) {
                0 => format!("workgroupUniformLoad(&room[{}])", self.value(scope, 0)),
                _ => "workgroupUniformLoad(&room[1])".to_owned(),
            },
            4 if !scope.arrays.is_empty() => {
                let array = &scope.arrays[self.random.below(scope.arrays.len())];
                format!("{array}[{}]", self.value(scope, depth - 1))
            }
            5 | 6 => {
                let giving = self.functions.iter().filter(|function| function.gives);
                let giving: Vec<_> = giving.cloned().collect();
                let called = giving.get(self.random.below(giving.len()));
                let call = called.and_then(|called| self.call(scope, called));
                call.unwrap_or_else(|| self.leaf(scope))
            }
            _ => self.leaf(scope),
        }
    }

    fn leaf(&mut self, scope: &Scope) -> String {
        if self.random.one_in(self.differs * 2) {
            let shared = ["own", "shared_values[0]", "room[0]"];
            let known = if self.fragment { 1 } else { 3 };
            return self.random.choose(&shared[..known]).to_owned();
        }
        let mut leaves: Vec<_> = ["1", "2", "same.x", "same_values[0]"]
            .map(str::to_owned)
            .to_vec();
        for value in &scope.values {
            leaves.extend([value.clone(), value.clone()]);
        }
        leaves.extend(scope.arrays.iter().map(|array| format!("{array}[2]")));
        leaves.extend(scope.pointers.iter().map(|pointer| format!("*{pointer}")));
        let through = |pointer: &String| format!("(*{pointer})[1]");
        leaves.extend(scope.array_pointers.iter().map(through));
        leaves.swap_remove(self.random.below(leaves.len()))
    }

    /// A call of `called`; none where there is nothing to point to. No two arguments lead to one variable, which
    /// would be an error of another kind.
    fn call(&mut self, scope: &Scope, called: &Function) -> Option<String> {
        let pointers = called
            .parameters
            .iter()
            .filter(|kind| **kind != Kind::Value);
        let aliases = pointers.count() > 0;
        let mut variables = scope.variables.clone();
        let mut arrays = scope.arrays.clone();
        let mut arguments = Vec::new();
        for kind in &called.parameters {
            let from = match kind {
                // A variable that a pointer may lead to is not read in the same call.
                Kind::Value if aliases => {
                    arguments.push("same.x".to_owned());
                    continue;
                }
                Kind::Value => {
                    arguments.push(self.value(scope, 1));
                    continue;
                }
                Kind::Pointer => &mut variables,
                Kind::ArrayPointer => &mut arrays,
            };
            if from.is_empty() {
                return None;
            }
            let index = self.random.below(from.len());
            arguments.push(format!("&{}", from.swap_remove(index)));
        }
        Some(format!("{}({})", called.name, arguments.join(", ")))
    }

    fn name(&mut self, kind: char) -> String {
        self.names += 1;
        format!("{kind}{}_", self.names)
    }
}

/// Whether nothing may follow the statements of `text`.
fn ends(text: &str) -> bool {
    let last = text.trim_end().rsplit('\n').next().unwrap_or("");
    last == "break;" || last == "continue;" || last.starts_with("return")
}

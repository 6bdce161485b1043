//! Marks: unique words that replace a module's names while naga writes it.

use std::collections::{HashMap, HashSet};

use naga::{
    ArraySize, Block, Expression, Function, Handle, Module, PredeclaredType, Span, Statement, Type,
    TypeInner,
    proc::{LayoutError, Layouter},
};

/// A mark consists of this start, its number, and the end: ASCII letters, digits and single `_`, with a letter
/// last. Naga leaves such a name unchanged, and none of its own words begins like this.
const START: &str = "umbrage_";
const END: &str = "n";

/// A module in which every name is a mark.
pub(super) struct Marked {
    pub(super) module: Module,
    /// Marked things, by the mark's number.
    pub(super) things: Vec<Thing>,
    /// Tellers of the initializers of overrides and variables, by the marks of these.
    pub(super) values: HashMap<usize, usize>,
    /// Workgroup sizes that depend on overrides, by the marks of entry points.
    pub(super) workgroup_sizes: HashMap<usize, [Size; 3]>,
    /// Initializers for local variables whose types have no name in WGSL, from which their types are inferred.
    pub(super) inferred: HashMap<usize, String>,
    /// A local variable that cannot be declared in WGSL.
    pub(super) undeclarable: Option<(String, Span)>,
    /// Lengths of arrays, by the numbers that stand for them.
    pub(super) lengths: HashMap<u32, Length>,
    /// Marks of tellers: functions made only so that naga writes an expression.
    tellers: HashSet<usize>,
    /// Marks of the overrides, in their order.
    overrides: Vec<usize>,
}

/// Something that has a mark.
#[derive(Debug)]
pub(super) struct Thing {
    /// Its name in the module.
    pub(super) name: String,
    pub(super) scope: Scope,
    /// For a struct's member, the `@size` that it must have; none where it takes no more room than it needs.
    pub(super) room: Option<u32>,
}

/// Scope in which a name is visible.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scope {
    /// The whole module.
    Module(Rank),
    /// Its struct, which has no other member of that name.
    Struct,
    /// The function with this mark.
    Function(usize),
    /// None: the name is not printed.
    Unsaid,
}

/// Order in which things with the same name may claim it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Rank {
    /// Things that a host finds only by name.
    Host,
    /// Things whose name a host finds in the reflection.
    Resource,
    /// All other things.
    Other,
}

/// A workgroup's size along an axis.
#[derive(Clone, Copy, Debug)]
pub(super) enum Size {
    Number(u32),
    /// The expression of this teller.
    Told(usize),
}

/// An array's length.
#[derive(Clone, Copy, Debug)]
pub(super) enum Length {
    /// The override with this mark.
    Override(usize),
    /// The expression of this teller.
    Told(usize),
}

impl Marked {
    pub(super) fn new(module: &Module) -> Result<Self, LayoutError> {
        let mut marked = Self {
            module: module.clone(),
            things: Vec::new(),
            values: HashMap::new(),
            workgroup_sizes: HashMap::new(),
            inferred: HashMap::new(),
            undeclarable: None,
            lengths: HashMap::new(),
            tellers: HashSet::new(),
            overrides: Vec::new(),
        };
        marked.structs(module)?;
        for (handle, constant) in module.constants.iter() {
            if constant.name.is_some() {
                let mark = marked.named(&constant.name, Scope::Module(Rank::Other));
                marked.module.constants.get_mut(handle).name = Some(word(mark));
            }
        }
        marked.overrides(module);
        marked.variables(module);
        for (handle, original) in module.functions.iter() {
            let mark = marked.named(&original.name, Scope::Module(Rank::Other));
            let mut function = original.clone();
            function.name = Some(word(mark));
            marked.within(mark, &mut function);
            *marked.module.functions.get_mut(handle) = function;
        }
        marked.entry_points(module);
        Ok(marked)
    }

    /// Number of the mark `word`; none where it is not a mark.
    pub(super) fn number(word: &str) -> Option<usize> {
        let number = word.strip_prefix(START)?.strip_suffix(END)?;
        number.parse().ok()
    }

    /// Makes a mark for a thing with the name `name`.
    pub(super) fn mark(&mut self, name: &str, scope: Scope) -> usize {
        self.things.push(Thing {
            name: name.to_owned(),
            scope,
            room: None,
        });
        self.things.len() - 1
    }

    /// Whether the module has tellers, which its author did not write.
    pub(super) fn has_tellers(&self) -> bool {
        !self.tellers.is_empty()
    }

    pub(super) fn is_teller(&self, mark: usize) -> bool {
        self.tellers.contains(&mark)
    }

    /// Replaces each array length that is an override, which naga cannot write, by a number.
    pub(super) fn put_numbers_for_lengths(&mut self) {
        let lengths = |inner: &TypeInner| match *inner {
            TypeInner::Array { size, .. } | TypeInner::BindingArray { size, .. } => Some(size),
            _ => None,
        };
        let mut constant = HashSet::new();
        let mut pending = Vec::new();
        for (handle, ty) in self.module.types.iter() {
            match lengths(&ty.inner) {
                Some(ArraySize::Constant(length)) => {
                    constant.insert(length.get());
                }
                Some(ArraySize::Pending(item)) => pending.push((handle, ty.clone(), item)),
                Some(ArraySize::Dynamic) | None => {}
            }
        }
        let free = (1..=u32::MAX).rev().filter(|n| !constant.contains(n));
        let mut free = free.filter_map(std::num::NonZeroU32::new);
        let mut numbers = HashMap::new();
        for (handle, mut ty, item) in pending {
            let number = numbers.entry(item).or_insert_with(|| free.next());
            if let (
                Some(number),
                TypeInner::Array { size, .. } | TypeInner::BindingArray { size, .. },
            ) = (*number, &mut ty.inner)
            {
                *size = ArraySize::Constant(number);
                let mark = self.overrides[item.index()];
                let length = match self.things[mark].scope {
                    Scope::Unsaid => self.values.get(&mark).copied().map(Length::Told),
                    _ => Some(Length::Override(mark)),
                };
                self.lengths
                    .extend(length.map(|length| (number.get(), length)));
                self.module.types.replace(handle, ty);
            }
        }
    }

    fn named(&mut self, name: &Option<String>, scope: Scope) -> usize {
        self.mark(name.as_deref().unwrap_or("unnamed"), scope)
    }

    /// Marks structs and their members, except for WGSL's own.
    fn structs(&mut self, module: &Module) -> Result<(), LayoutError> {
        let mut layouter = Layouter::default();
        layouter.update(module.to_ctx())?;
        let predeclared: HashSet<_> = module.special_types.predeclared_types.values().collect();
        for (handle, ty) in module.types.iter() {
            let TypeInner::Struct { members, span } = &ty.inner else {
                continue;
            };
            if predeclared.contains(&handle) {
                continue;
            }
            let name = self.named(&ty.name, Scope::Module(Rank::Other));
            let mut marked = members.clone();
            let rooms = rooms(&layouter, members, *span);
            for (member, room) in marked.iter_mut().zip(rooms) {
                let mark = self.named(&member.name, Scope::Struct);
                self.things[mark].room = room;
                member.name = Some(word(mark));
            }
            let inner = TypeInner::Struct {
                members: marked,
                span: *span,
            };
            let name = Some(word(name));
            self.module.types.replace(handle, Type { name, inner });
        }
        Ok(())
    }

    fn overrides(&mut self, module: &Module) {
        let says_all = says_all(module);
        for (handle, item) in module.overrides.iter() {
            let scope = match (&item.name, item.id) {
                (None, None) => Scope::Unsaid,
                (Some(_), None) => Scope::Module(Rank::Host),
                (_, Some(_)) => Scope::Module(Rank::Other),
            };
            let mark = self.named(&item.name, scope);
            self.overrides.push(mark);
            let marked = self.module.overrides.get_mut(handle);
            marked.name = Some(word(mark));
            if let Some(init) = item.init
                && (!says_all || scope == Scope::Unsaid)
            {
                marked.init = None;
                let teller = self.teller(module, init);
                self.values.insert(mark, teller);
            }
        }
    }

    fn variables(&mut self, module: &Module) {
        let says_all = says_all(module);
        for (handle, variable) in module.global_variables.iter() {
            let rank = match variable.binding {
                Some(_) => Rank::Resource,
                None => Rank::Other,
            };
            let mark = self.named(&variable.name, Scope::Module(rank));
            let marked = self.module.global_variables.get_mut(handle);
            marked.name = Some(word(mark));
            if let Some(init) = variable.init
                && !says_all
            {
                marked.init = None;
                let teller = self.teller(module, init);
                self.values.insert(mark, teller);
            }
        }
    }

    fn entry_points(&mut self, module: &Module) {
        for (index, entry) in module.entry_points.iter().enumerate() {
            let mark = self.mark(&entry.name, Scope::Module(Rank::Host));
            let mut marked = entry.clone();
            marked.name = word(mark);
            self.within(mark, &mut marked.function);
            if let Some(overrides) = marked.workgroup_size_overrides.take() {
                let mut sizes = entry.workgroup_size.map(Size::Number);
                for (size, told) in sizes.iter_mut().zip(overrides) {
                    if let Some(expression) = told {
                        *size = Size::Told(self.teller(module, expression));
                    }
                }
                self.workgroup_sizes.insert(mark, sizes);
                marked.workgroup_size = [1; 3];
            }
            self.module.entry_points[index] = marked;
        }
    }

    /// Marks the names that are visible only in the function with the mark `mark`.
    fn within(&mut self, mark: usize, function: &mut Function) {
        let scope = Scope::Function(mark);
        for argument in &mut function.arguments {
            argument.name = Some(word(self.named(&argument.name, scope)));
        }
        for (_, local, span) in function.local_variables.iter_mut_span() {
            let mark = self.named(&local.name, scope);
            local.name = Some(word(mark));
            let predeclared = &self.module.special_types.predeclared_types;
            if let Some((ty, _)) = predeclared.iter().find(|(_, ty)| **ty == local.ty) {
                match zero(ty) {
                    Some(value) => {
                        self.inferred.insert(mark, value);
                    }
                    None => self.undeclarable = Some((self.things[mark].name.clone(), *span)),
                }
            }
        }
        for name in function.named_expressions.values_mut() {
            *name = word(self.mark(name, scope));
        }
    }

    /// Adds a teller for one of `module`'s own expressions. Its body only returns the expression, with no statement
    /// that evaluates a part of it, so naga writes the whole expression in one place.
    fn teller(&mut self, module: &Module, expression: Handle<Expression>) -> usize {
        let mark = self.mark("", Scope::Unsaid);
        let mut body = Block::new();
        let value = Some(expression);
        body.push(Statement::Return { value }, Span::UNDEFINED);
        let function = Function {
            name: Some(word(mark)),
            expressions: module.global_expressions.clone(),
            body,
            ..Function::default()
        };
        self.module.functions.append(function, Span::UNDEFINED);
        self.tellers.insert(mark);
        mark
    }
}

fn word(mark: usize) -> String {
    format!("{START}{mark}{END}")
}

/// Text of a call that returns the zero value of the predeclared type `ty`; none where there is no such call.
fn zero(ty: &PredeclaredType) -> Option<String> {
    let (function, size, scalar) = match *ty {
        PredeclaredType::ModfResult { size, scalar } => ("modf", size, scalar),
        PredeclaredType::FrexpResult { size, scalar } => ("frexp", size, scalar),
        PredeclaredType::AtomicCompareExchangeWeakResult(_) => return None,
    };
    let scalar = if scalar.width == 2 { "f16" } else { "f32" };
    Some(match size {
        Some(size) => format!("{function}(vec{}<{scalar}>())", u32::from(size)),
        None => format!("{function}({scalar}())"),
    })
}

/// Whether naga can write all of the module-scope expressions.
fn says_all(module: &Module) -> bool {
    let mut expressions = module.global_expressions.iter();
    expressions.all(|(_, expression)| {
        matches!(
            expression,
            Expression::Literal(_)
                | Expression::Constant(_)
                | Expression::Override(_)
                | Expression::ZeroValue(_)
                | Expression::Compose { .. }
                | Expression::Splat { .. }
        )
    })
}

/// For each member of a struct, the `@size` that it must have, if it takes more room than it needs.
fn rooms(layouter: &Layouter, members: &[naga::StructMember], span: u32) -> Vec<Option<u32>> {
    let alignments = members.iter().map(|member| layouter[member.ty].alignment);
    let Some(alignment) = alignments.max() else {
        return Vec::new();
    };
    let rooms = members.iter().enumerate().map(|(index, member)| {
        let natural = member.offset + layouter[member.ty].size;
        let (expected, end) = match members.get(index + 1) {
            Some(next) => (layouter[next.ty].alignment.round_up(natural), next.offset),
            None => (alignment.round_up(natural), span),
        };
        (expected != end).then(|| end - member.offset)
    });
    rooms.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Makes sure that no mark is one of naga's own words.
    #[test]
    fn no_word_of_wgsl_looks_like_a_mark() {
        let own = naga::keywords::wgsl::RESERVED.iter();
        let own = own.chain(naga::keywords::wgsl::BUILTIN_IDENTIFIERS);
        assert!(own.into_iter().all(|word| !word.starts_with(START)));
    }

    /// Makes sure that naga leaves marks unchanged.
    #[test]
    fn naga_leaves_marks_alone() {
        let mut namer = naga::proc::Namer::default();
        for mark in [0, 1, 9, 10, 12_345] {
            let name = word(mark);
            assert_eq!(namer.call(&name), name);
            assert_eq!(Marked::number(&name), Some(mark));
        }
    }
}

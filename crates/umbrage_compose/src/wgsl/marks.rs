//! Marks: words that stand for a module's names while naga writes it.

use std::collections::{HashMap, HashSet};

use naga::{
    ArraySize, Block, Expression, Function, Handle, Module, PredeclaredType, Span, Statement, Type,
    TypeInner,
    proc::{LayoutError, Layouter},
};

/// A mark is this, its number, and the end: ASCII letters, digits and single `_`, with a letter last, which is a name
/// that naga leaves as it is. No word that it writes itself begins so.
const START: &str = "umbrage_";
const END: &str = "n";

/// A module in which every name is a mark.
pub(super) struct Marked {
    pub(super) module: Module,
    /// What has a mark, by the mark's number.
    pub(super) things: Vec<Thing>,
    /// The tellers of what overrides and variables begin with, by the marks of these.
    pub(super) values: HashMap<usize, usize>,
    /// Sizes of workgroups that depend on overrides, by the marks of entry points.
    pub(super) workgroup_sizes: HashMap<usize, [Size; 3]>,
    /// What local variables begin with whose types have no name in WGSL, to say what type they are.
    pub(super) inferred: HashMap<usize, String>,
    /// A local variable that WGSL has no way to declare.
    pub(super) undeclarable: Option<(String, Span)>,
    /// The lengths of arrays that numbers stand for.
    pub(super) lengths: HashMap<u32, Length>,
    /// Tellers: functions that only tell an expression.
    tellers: HashSet<usize>,
    /// The overrides' marks, in their order.
    overrides: Vec<usize>,
}

/// Something that has a mark.
#[derive(Debug)]
pub(super) struct Thing {
    /// Its name in the module.
    pub(super) name: String,
    pub(super) scope: Scope,
    /// Of a struct's member, the bytes that it must ask for; none where it takes no more than it needs.
    pub(super) room: Option<u32>,
}

/// Where a name is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scope {
    /// In the whole module.
    Module(Rank),
    /// In its struct, which has no other of that name.
    Struct,
    /// In the function of this mark.
    Function(usize),
    /// Nowhere: it is not printed.
    Unsaid,
}

/// What of several things has the first claim on a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Rank {
    /// What a host can find by its name alone.
    Host,
    /// What a host finds by its name in the reflection.
    Resource,
    /// Everything else.
    Other,
}

/// A workgroup's size along an axis.
#[derive(Clone, Copy, Debug)]
pub(super) enum Size {
    Number(u32),
    /// What this teller tells.
    Told(usize),
}

/// An array's length.
#[derive(Clone, Copy, Debug)]
pub(super) enum Length {
    /// The override of this mark.
    Override(usize),
    /// What this teller tells.
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

    /// The number of the mark `word`, if it is one.
    pub(super) fn number(word: &str) -> Option<usize> {
        let number = word.strip_prefix(START)?.strip_suffix(END)?;
        number.parse().ok()
    }

    /// Makes a mark for what is called `name`.
    pub(super) fn mark(&mut self, name: &str, scope: Scope) -> usize {
        self.things.push(Thing {
            name: name.to_owned(),
            scope,
            room: None,
        });
        self.things.len() - 1
    }

    /// Whether there are functions that the module's author did not write.
    pub(super) fn has_tellers(&self) -> bool {
        !self.tellers.is_empty()
    }

    pub(super) fn is_teller(&self, mark: usize) -> bool {
        self.tellers.contains(&mark)
    }

    /// Puts a number in the place of each array's length that is an override, for which naga has no words.
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

    /// Marks structs and their members, but for those that are WGSL's own.
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

    /// Marks what is known in the function of mark `mark` alone.
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

    /// Adds a function that tells one of `module`'s own expressions. Nothing in it is computed by a statement of
    /// its own, so that the whole expression is written in one place.
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

/// A call that gives zeros of the predeclared type `ty`; none where there is none.
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

/// Whether naga has words for all of the module's own expressions.
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

/// For each of a struct's members the room that it must ask for, if it takes more than it needs.
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

    /// What makes it certain that no mark is one of naga's own words.
    #[test]
    fn no_word_of_wgsl_looks_like_a_mark() {
        let own = naga::keywords::wgsl::RESERVED.iter();
        let own = own.chain(naga::keywords::wgsl::BUILTIN_IDENTIFIERS);
        assert!(own.into_iter().all(|word| !word.starts_with(START)));
    }

    /// What makes it certain that naga leaves marks as they are.
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

//! Copying what functions stand on: types, constants, overrides, variables and constant expressions.

use std::sync::Arc;

use naga::{
    Constant, Expression, GlobalVariable, Handle, Override, ResourceBinding, Span, Type, TypeInner,
};

use crate::{Fault, link::Linker, reach::Program as _, unit::Unit};

impl Linker<'_> {
    pub(crate) fn ty(
        &mut self,
        module: usize,
        unit: &Arc<Unit>,
        handle: Handle<Type>,
    ) -> Result<Handle<Type>, Fault> {
        let number = unit.type_numbers[handle.index()];
        let done = match number {
            Some(number) => self.types.get(number).copied().flatten(),
            None => self.copies.types.get(&(module, handle)).copied(),
        };
        if let Some(done) = done {
            return Ok(done);
        }
        let mut inner = unit.module.types[handle].inner.clone();
        match &mut inner {
            TypeInner::Pointer { base, .. } => *base = self.ty(module, unit, *base)?,
            TypeInner::Array { base, size, .. } | TypeInner::BindingArray { base, size } => {
                *base = self.ty(module, unit, *base)?;
                if let naga::ArraySize::Pending(item) = size {
                    *item = self.override_(module, unit, *item)?;
                }
            }
            TypeInner::Struct { members, .. } => {
                for member in members {
                    member.ty = self.ty(module, unit, member.ty)?;
                }
            }
            _ => {}
        }
        let name = unit.type_names[handle.index()].clone();
        let span = self.shifted(module, unit, unit.module.types.get_span(handle));
        let copied = self.out.types.insert(Type { name, inner }, span);
        match number {
            Some(number) => {
                let room = self.types.len().max(number + 1);
                self.types.resize(room, None);
                self.types[number] = Some(copied);
            }
            None => drop(self.copies.types.insert((module, handle), copied)),
        }
        Ok(copied)
    }

    pub(crate) fn constant(
        &mut self,
        module: usize,
        unit: &Arc<Unit>,
        handle: Handle<Constant>,
    ) -> Result<Handle<Constant>, Fault> {
        if let Some(done) = self.copies.constants.get(&(module, handle)) {
            return Ok(*done);
        }
        // A stand-in has the value of what it stands for.
        let item = unit.constants.get(&handle);
        let item = item.map(|item| self.targets.item(module, item));
        if let Some(done) = item.as_deref().and_then(|item| self.constants.get(item)) {
            self.copies.constants.insert((module, handle), *done);
            return Ok(*done);
        }
        let original = &unit.module.constants[handle];
        let mut name = item.as_ref().map(|item| item.name.clone());
        self.rename(item.as_ref().map_or(module, |item| item.module), &mut name);
        let copied = Constant {
            name,
            ty: self.ty(module, unit, original.ty)?,
            init: self.expression(module, unit, original.init)?,
        };
        let span = self.shifted(module, unit, unit.module.constants.get_span(handle));
        let copied = self.out.constants.append(copied, span);
        self.copies.constants.insert((module, handle), copied);
        if let Some(item) = item {
            self.constants.insert(item.into_owned(), copied);
        }
        Ok(copied)
    }

    pub(crate) fn override_(
        &mut self,
        module: usize,
        unit: &Arc<Unit>,
        handle: Handle<Override>,
    ) -> Result<Handle<Override>, Fault> {
        if let Some(done) = self.copies.overrides.get(&(module, handle)) {
            return Ok(*done);
        }
        // Naga stores an array length that is an expression as an override without a name.
        let item = unit.overrides.get(&handle);
        if let Some(done) = item.and_then(|item| self.overrides.get(item)) {
            self.copies.overrides.insert((module, handle), *done);
            return Ok(*done);
        }
        // A host sets it once, for all instances.
        if let Some(item) = item.filter(|item| item.module != self.targets.module(module)) {
            let home = self.targets.number(module, item.module);
            let owner = self.unit(home)?;
            let own = owner
                .overrides
                .iter()
                .find(|(_, known)| *known == item)
                .map(|(handle, _)| *handle);
            if let Some(own) = own {
                return self.override_(home, &owner, own);
            }
        }
        let original = &unit.module.overrides[handle];
        let copied = Override {
            name: original.name.clone(),
            id: original.id,
            ty: self.ty(module, unit, original.ty)?,
            init: match original.init {
                Some(init) => Some(self.expression(module, unit, init)?),
                None => None,
            },
        };
        let span = self.shifted(module, unit, unit.module.overrides.get_span(handle));
        let copied = self.out.overrides.append(copied, span);
        self.copies.overrides.insert((module, handle), copied);
        if let Some(item) = item {
            self.overrides.insert(item.clone(), copied);
        }
        Ok(copied)
    }

    pub(crate) fn global(
        &mut self,
        module: usize,
        unit: &Arc<Unit>,
        handle: Handle<GlobalVariable>,
    ) -> Result<Handle<GlobalVariable>, Fault> {
        if let Some(done) = self.copies.globals.get(&(module, handle)) {
            return Ok(*done);
        }
        let item = self.targets.item(module, &unit.globals[handle.index()]);
        let copied = match self.globals.get(&*item) {
            Some(done) => *done,
            None => self.new_global(module, unit, handle)?,
        };
        self.copies.globals.insert((module, handle), copied);
        Ok(copied)
    }

    fn new_global(
        &mut self,
        module: usize,
        unit: &Arc<Unit>,
        handle: Handle<GlobalVariable>,
    ) -> Result<Handle<GlobalVariable>, Fault> {
        let item = self.targets.item(module, &unit.globals[handle.index()]);
        if item.module != module {
            let owner = self.unit(item.module)?;
            if let Some(own) = owner.own_globals.get(&item.name) {
                return self.global(item.module, &owner, *own);
            }
        }
        let original = &unit.module.global_variables[handle];
        let mut name = original.name.clone();
        self.rename(module, &mut name);
        let copied = GlobalVariable {
            name,
            ty: self.ty(module, unit, original.ty)?,
            init: match original.init {
                Some(init) => Some(self.expression(module, unit, init)?),
                None => None,
            },
            space: self.targets.space(module, original.space),
            binding: original.binding.map(|binding| ResourceBinding {
                group: self.targets.group(module, binding.group),
                ..binding
            }),
            memory_decorations: original.memory_decorations,
        };
        let span = self.shifted(module, unit, unit.module.global_variables.get_span(handle));
        let copied = self.out.global_variables.append(copied, span);
        let item = item.into_owned();
        self.owners.push(item.clone());
        self.globals.insert(item, copied);
        Ok(copied)
    }

    /// The copy of a constant expression.
    pub(crate) fn expression(
        &mut self,
        module: usize,
        unit: &Arc<Unit>,
        handle: Handle<Expression>,
    ) -> Result<Handle<Expression>, Fault> {
        if let Some(done) = self.copies.expressions.get(&(module, handle)) {
            return Ok(*done);
        }
        let mut copied = unit.module.global_expressions[handle].clone();
        match &mut copied {
            Expression::Compose { components, .. } => {
                for component in components {
                    *component = self.expression(module, unit, *component)?;
                }
            }
            Expression::Access { base, index } => {
                *base = self.expression(module, unit, *base)?;
                *index = self.expression(module, unit, *index)?;
            }
            Expression::AccessIndex { base: inner, .. }
            | Expression::Splat { value: inner, .. }
            | Expression::Swizzle { vector: inner, .. }
            | Expression::Unary { expr: inner, .. }
            | Expression::Relational {
                argument: inner, ..
            }
            | Expression::As { expr: inner, .. } => {
                *inner = self.expression(module, unit, *inner)?
            }
            Expression::Binary { left, right, .. } => {
                *left = self.expression(module, unit, *left)?;
                *right = self.expression(module, unit, *right)?;
            }
            Expression::Select {
                condition,
                accept,
                reject,
            } => {
                *condition = self.expression(module, unit, *condition)?;
                *accept = self.expression(module, unit, *accept)?;
                *reject = self.expression(module, unit, *reject)?;
            }
            Expression::Math {
                arg,
                arg1,
                arg2,
                arg3,
                ..
            } => {
                *arg = self.expression(module, unit, *arg)?;
                for arg in [arg1, arg2, arg3].into_iter().flatten() {
                    *arg = self.expression(module, unit, *arg)?;
                }
            }
            _ => {}
        }
        self.outside(module, unit, &mut copied)?;
        let span = self.shifted(
            module,
            unit,
            unit.module.global_expressions.get_span(handle),
        );
        let copied = self.out.global_expressions.append(copied, span);
        self.copies.expressions.insert((module, handle), copied);
        Ok(copied)
    }

    /// `span` of a unit's module-level arenas, counted from the start of the library's texts.
    pub(crate) fn shifted(&self, module: usize, unit: &Unit, span: Span) -> Span {
        let base = self.targets.source(module).base;
        crate::unit::shifted(span, base, unit.own())
    }
}

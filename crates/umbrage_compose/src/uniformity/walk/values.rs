//! Dependencies of expressions, roots of pointers, and sources of non-uniformity.

use naga::{
    AddressSpace, Binding, BuiltIn, Expression, GlobalVariable, Handle, ImageClass, ImageQuery,
    SampleLevel, ShaderStage, StorageAccess, Type, TypeInner,
};

use super::{
    super::{
        Check, Demand, What,
        graph::{DIFFERS, DIFFERS_IN_WORKGROUP, Node, UNIFORM},
    },
    Root, Walk,
};

impl Walk<'_> {
    /// The value of `handle`, evaluated in the control flow `flow`.
    pub(super) fn evaluate(&mut self, handle: Handle<Expression>, flow: Node) -> Node {
        let expression = &self.function.expressions[handle];
        let mut on = vec![flow];
        if let Some(demand) = Demand::of_expression(expression) {
            let span = self.function.expressions.get_span(handle);
            self.demand(demand, span, flow);
            on.push(DIFFERS);
        }
        match expression {
            Expression::Load { pointer } => {
                on.push(match self.root(*pointer).0 {
                    Root::Variable(variable) => self.held[variable],
                    Root::Constant => UNIFORM,
                    Root::Outside => DIFFERS,
                });
            }
            Expression::ImageLoad { image, .. } if self.is_writable_image(*image) => {
                on.push(DIFFERS);
            }
            Expression::RayQueryVertexPositions { .. }
            | Expression::RayQueryGetIntersection { .. } => on.push(DIFFERS),
            _ => {}
        }
        for_each_operand(expression, &mut |operand| on.push(self.value(operand)));
        on.retain(|node| *node != UNIFORM);
        match on.as_slice() {
            // A value that depends on nothing else is as uniform as the control flow in which it is computed.
            [only] if *only == flow => flow,
            _ => self.graph.node_on(What::Value(handle), on),
        }
    }

    fn is_writable_image(&self, mut image: Handle<Expression>) -> bool {
        loop {
            let ty = match &self.function.expressions[image] {
                Expression::Access { base, .. } | Expression::AccessIndex { base, .. } => {
                    image = *base;
                    continue;
                }
                Expression::GlobalVariable(global) => {
                    self.check.module.global_variables[*global].ty
                }
                Expression::FunctionArgument(index) => self.function.arguments[*index as usize].ty,
                _ => return false,
            };
            let types = &self.check.module.types;
            let inner = match types[ty].inner {
                TypeInner::BindingArray { base, .. } => &types[base].inner,
                ref other => other,
            };
            return matches!(
                inner,
                TypeInner::Image { class: ImageClass::Storage { access, .. }, .. }
                    if access.contains(StorageAccess::STORE)
            );
        }
    }

    /// Root of `pointer`, and whether it points to the whole of it.
    pub(super) fn root(&self, mut pointer: Handle<Expression>) -> (Root, bool) {
        let mut whole = true;
        loop {
            let root = match &self.function.expressions[pointer] {
                Expression::Access { base, .. } | Expression::AccessIndex { base, .. } => {
                    pointer = *base;
                    whole = false;
                    continue;
                }
                Expression::LocalVariable(local) => Root::Variable(local.index()),
                Expression::FunctionArgument(index) => {
                    let argument = &self.function.arguments[*index as usize];
                    match space(&self.check.module.types[argument.ty].inner) {
                        Some(AddressSpace::Function) => {
                            let locals = self.function.local_variables.len();
                            Root::Variable(locals + *index as usize)
                        }
                        Some(space) => memory(space),
                        None => Root::Constant,
                    }
                }
                Expression::GlobalVariable(global) => {
                    let GlobalVariable { space, .. } = &self.check.module.global_variables[*global];
                    memory(*space)
                }
                _ => Root::Constant,
            };
            return (root, whole);
        }
    }
}

/// Address space of a pointer type.
pub(super) fn space(ty: &TypeInner) -> Option<AddressSpace> {
    match ty {
        TypeInner::Pointer { space, .. } | TypeInner::ValuePointer { space, .. } => Some(*space),
        _ => None,
    }
}

fn memory(space: AddressSpace) -> Root {
    match space {
        AddressSpace::Uniform | AddressSpace::Handle | AddressSpace::Immediate => Root::Constant,
        AddressSpace::Storage { access } if !access.contains(StorageAccess::STORE) => {
            Root::Constant
        }
        _ => Root::Outside,
    }
}

/// Node for the uniformity of an entry point's input; for a struct, that of its least uniform member.
pub(super) fn differs(
    check: &Check<'_>,
    stage: ShaderStage,
    binding: Option<&Binding>,
    ty: Handle<Type>,
) -> Node {
    match binding {
        Some(Binding::BuiltIn(builtin)) => match builtin {
            BuiltIn::WorkGroupId
            | BuiltIn::NumWorkGroups
            | BuiltIn::WorkGroupSize
            | BuiltIn::NumSubgroups => UNIFORM,
            BuiltIn::SubgroupSize if stage == ShaderStage::Compute => UNIFORM,
            BuiltIn::SubgroupSize | BuiltIn::SubgroupId => DIFFERS_IN_WORKGROUP,
            _ => DIFFERS,
        },
        Some(_) => DIFFERS,
        None => match &check.module.types[ty].inner {
            TypeInner::Struct { members, .. } => members
                .iter()
                .map(|member| differs(check, stage, member.binding.as_ref(), member.ty))
                .max()
                .unwrap_or(UNIFORM),
            _ => DIFFERS,
        },
    }
}

/// Calls `visit` for each operand of `expression`.
pub(crate) fn for_each_operand(
    expression: &Expression,
    visit: &mut impl FnMut(Handle<Expression>),
) {
    match expression {
        Expression::Literal(_)
        | Expression::Constant(_)
        | Expression::Override(_)
        | Expression::ZeroValue(_)
        | Expression::FunctionArgument(_)
        | Expression::GlobalVariable(_)
        | Expression::LocalVariable(_)
        | Expression::CallResult(_)
        | Expression::AtomicResult { .. }
        | Expression::WorkGroupUniformLoadResult { .. }
        | Expression::RayQueryProceedResult
        | Expression::SubgroupBallotResult
        | Expression::SubgroupOperationResult { .. } => {}
        Expression::Compose { components, .. } => components.iter().copied().for_each(visit),
        Expression::Access { base, index } => {
            visit(*base);
            visit(*index);
        }
        Expression::AccessIndex { base: only, .. }
        | Expression::Splat { value: only, .. }
        | Expression::Swizzle { vector: only, .. }
        | Expression::Load { pointer: only }
        | Expression::Unary { expr: only, .. }
        | Expression::Derivative { expr: only, .. }
        | Expression::Relational { argument: only, .. }
        | Expression::As { expr: only, .. }
        | Expression::ArrayLength(only)
        | Expression::RayQueryVertexPositions { query: only, .. }
        | Expression::RayQueryGetIntersection { query: only, .. } => visit(*only),
        Expression::ImageSample {
            image,
            sampler,
            coordinate,
            array_index,
            offset,
            level,
            depth_ref,
            ..
        } => {
            [*image, *sampler, *coordinate]
                .into_iter()
                .for_each(&mut *visit);
            let optional = [array_index, offset, depth_ref];
            optional
                .into_iter()
                .flatten()
                .copied()
                .for_each(&mut *visit);
            match level {
                SampleLevel::Auto | SampleLevel::Zero => {}
                SampleLevel::Exact(level) | SampleLevel::Bias(level) => visit(*level),
                SampleLevel::Gradient { x, y } => {
                    visit(*x);
                    visit(*y);
                }
            }
        }
        Expression::ImageLoad {
            image,
            coordinate,
            array_index,
            sample,
            level,
        } => {
            visit(*image);
            visit(*coordinate);
            let optional = [array_index, sample, level];
            optional.into_iter().flatten().copied().for_each(visit);
        }
        Expression::ImageQuery { image, query } => {
            visit(*image);
            if let ImageQuery::Size { level: Some(level) } = query {
                visit(*level);
            }
        }
        Expression::Binary { left, right, .. } => {
            visit(*left);
            visit(*right);
        }
        Expression::Select {
            condition,
            accept,
            reject,
        } => [*condition, *accept, *reject].into_iter().for_each(visit),
        Expression::Math {
            arg,
            arg1,
            arg2,
            arg3,
            ..
        } => {
            visit(*arg);
            [arg1, arg2, arg3]
                .into_iter()
                .flatten()
                .copied()
                .for_each(visit);
        }
        Expression::CooperativeLoad { data, .. } => {
            visit(data.pointer);
            visit(data.stride);
        }
        Expression::CooperativeMultiplyAdd { a, b, c } => {
            [*a, *b, *c].into_iter().for_each(visit);
        }
    }
}

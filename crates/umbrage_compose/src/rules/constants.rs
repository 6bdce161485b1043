//! Constants out of range: code that WGSL refuses because some of its arguments are constants, even where others
//! are not, and expressions that naga does not evaluate. Overrides count with their defaults, as in a pipeline that
//! sets no values for them.
//!
//! Naga evaluates expressions of constants only, and reports the errors in them. Expressions that it cannot
//! evaluate stay in its IR as they were written, and so do those with only some constant arguments.

use naga::{
    BinaryOperator, Expression, Function, Handle, Literal, Module, Override, RelationalFunction,
    Scalar, Span, TypeInner, UnaryOperator, front::Typifier, proc::ResolveContext,
};

use super::{
    Problem,
    math::math,
    value::{Value, converted, integer, length, number, recast, written},
};

/// Number of bits of WGSL's integers.
pub(super) const BITS: i64 = 32;

/// Constant values of the module-scope expressions, by their indices.
pub(crate) struct Constants<'a> {
    module: &'a Module,
    values: Vec<Option<Value>>,
}

/// Reason to refuse an expression: the error, and the advice.
pub(super) struct Refusal {
    message: String,
    advice: &'static str,
}

impl Refusal {
    fn at(self, span: Span) -> Problem {
        Problem {
            span,
            message: self.message,
            advice: self.advice,
        }
    }
}

pub(super) type Evaluated = Result<Option<Value>, Refusal>;

impl<'a> Constants<'a> {
    /// Evaluates the module-scope expressions.
    pub(super) fn new(module: &'a Module) -> Result<Self, Problem> {
        let mut constants = Self {
            module,
            values: Vec::with_capacity(module.global_expressions.len()),
        };
        for (handle, expression) in module.global_expressions.iter() {
            let get = |handle: Handle<Expression>| constants.values.get(handle.index()).copied()?;
            let value = constants.evaluate(expression, &get);
            let span = module.global_expressions.get_span(handle);
            constants
                .values
                .push(value.map_err(|refusal| refusal.at(span))?);
        }
        Ok(constants)
    }

    /// Integer value of the module-scope expression `handle`.
    pub(super) fn integer(&self, handle: Handle<Expression>) -> Option<i64> {
        integer(self.values.get(handle.index()).copied()??.component(0))
    }

    /// Default of the override `item`.
    pub(super) fn default(&self, item: Handle<Override>) -> Option<i64> {
        self.integer(self.module.overrides[item].init?)
    }

    /// Checks the expressions of `function`.
    pub(super) fn check(&self, function: &Function) -> Result<(), Problem> {
        let expressions = &function.expressions;
        let mut values: Vec<Option<Value>> = Vec::with_capacity(expressions.len());
        for (handle, expression) in expressions.iter() {
            let get = |handle: Handle<Expression>| values.get(handle.index()).copied()?;
            let value = self.evaluate(expression, &get).and_then(|value| {
                match *expression {
                    Expression::Access { base, index } => {
                        self.index_within(function, base, get(index))?;
                    }
                    Expression::ImageSample {
                        offset: Some(offset),
                        ..
                    } => offset_within(get(offset))?,
                    _ => {}
                }
                Ok(value)
            });
            let value = value.map_err(|refusal| refusal.at(expressions.get_span(handle)))?;
            // A value with the name of a `let` is never a constant. `_ = 1;` gives no name.
            let named = function.named_expressions.get(&handle);
            values.push(value.filter(|_| named.is_none_or(|name| name == "phony")));
        }
        Ok(())
    }

    fn index_within(
        &self,
        function: &Function,
        base: Handle<Expression>,
        index: Option<Value>,
    ) -> Result<(), Refusal> {
        let Some(index) = index.and_then(|index| integer(index.component(0))) else {
            return Ok(());
        };
        let context = ResolveContext::with_locals(
            self.module,
            &function.local_variables,
            &function.arguments,
        );
        let mut typifier = Typifier::new();
        if typifier
            .grow(base, &function.expressions, &context)
            .is_err()
        {
            // Naga's validator reports this one.
            return Ok(());
        }
        let length = length(self.module, typifier.get(base, &self.module.types));
        if index >= 0 && length.is_none_or(|length| index < length.into()) {
            return Ok(());
        }
        Err(Refusal {
            message: match length {
                Some(length) => {
                    format!("the index {index} is out of bounds: there are {length} elements")
                }
                None => format!("the index {index} is negative"),
            },
            advice: "count from 0 to one less than there are",
        })
    }

    /// Value of `expression`, where it is constant and of a kind that is handled here; `get` gives the values of
    /// its operands.
    fn evaluate(
        &self,
        expression: &Expression,
        get: &dyn Fn(Handle<Expression>) -> Option<Value>,
    ) -> Evaluated {
        let global = |handle: Handle<Expression>| self.values.get(handle.index()).copied()?;
        Ok(match *expression {
            Expression::Literal(literal) => Some(Value::scalar(literal)),
            Expression::ZeroValue(ty) => Value::zero(&self.module.types[ty]),
            Expression::Constant(constant) => global(self.module.constants[constant].init),
            Expression::Override(item) => self.module.overrides[item].init.and_then(global),
            Expression::Compose { ty, ref components } => match self.module.types[ty].inner {
                TypeInner::Vector { .. } => {
                    let parts: Option<Vec<_>> = components.iter().map(|part| get(*part)).collect();
                    let flat: Option<Vec<_>> = parts.map(|parts| {
                        let parts = parts.iter();
                        parts.flat_map(|part| part.components().to_vec()).collect()
                    });
                    flat.and_then(|flat| Value::from_components(&flat))
                }
                _ => None,
            },
            Expression::Splat { size, value } => get(value).map(|v| v.splat(size as usize)),
            Expression::Swizzle {
                size,
                vector,
                pattern,
            } => get(vector).and_then(|vector| {
                let chosen = pattern[..size as usize].iter();
                let chosen: Vec<_> = chosen.map(|c| vector.component(*c as usize)).collect();
                Value::from_components(&chosen)
            }),
            Expression::AccessIndex { base, index } => {
                get(base).map(|base| Value::scalar(base.component(index as usize)))
            }
            Expression::Unary { op, expr } => get(expr).and_then(|value| unary(op, value)),
            Expression::Binary { op, left, right } => binary(op, get(left), get(right))?,
            Expression::Select {
                condition,
                accept,
                reject,
            } => match (get(condition), get(accept), get(reject)) {
                (Some(condition), Some(accept), Some(reject)) => {
                    let length = accept.components().len();
                    let chosen = (0..length).map(|index| match condition.component(index) {
                        Literal::Bool(true) => accept.component(index),
                        _ => reject.component(index),
                    });
                    Value::from_components(&chosen.collect::<Vec<_>>())
                }
                _ => None,
            },
            Expression::Relational { fun, argument } => get(argument).and_then(|value| {
                let mut truths = value.components().iter().map(|c| *c == Literal::Bool(true));
                match fun {
                    RelationalFunction::All => Some(truths.all(|truth| truth)),
                    RelationalFunction::Any => Some(truths.any(|truth| truth)),
                    _ => None,
                }
                .map(|truth| Value::scalar(Literal::Bool(truth)))
            }),
            Expression::As {
                expr,
                kind,
                convert: Some(width),
            } => get(expr)
                .and_then(|value| value.map(|part| converted(part, Scalar { kind, width }))),
            Expression::As {
                expr,
                kind,
                convert: None,
            } => match get(expr).and_then(|value| value.map(|part| recast(part, kind))) {
                Some(value) => Some(finite(value, || "`bitcast`".to_owned())?),
                None => None,
            },
            Expression::Math {
                fun,
                arg,
                arg1,
                arg2,
                arg3,
            } => {
                let optional = |arg: Option<Handle<Expression>>| arg.and_then(get);
                let args = [get(arg), optional(arg1), optional(arg2), optional(arg3)];
                math(fun, args)?
            }
            _ => None,
        })
    }
}

/// Checks the offset of a texture fetch, in texels.
fn offset_within(offset: Option<Value>) -> Result<(), Refusal> {
    let texels = offset.iter().flat_map(|offset| offset.components());
    let outside = texels
        .copied()
        .find(|texels| integer(*texels).is_some_and(|texels| !(-8..=7).contains(&texels)));
    match outside {
        Some(texels) => Err(Refusal {
            message: format!(
                "a texture is fetched from at an offset of {} texels",
                written(texels)
            ),
            advice: "offsets go from -8 to 7 texels; move the coordinates instead",
        }),
        None => Ok(()),
    }
}

pub(super) fn finite(value: Value, what: impl Fn() -> String) -> Result<Value, Refusal> {
    let broken = |part: &&Literal| number(**part).is_some_and(|number| !number.is_finite());
    match value.components().iter().find(broken) {
        Some(part) => Err(Refusal {
            message: format!("{} is {}, which no constant may be", what(), written(*part)),
            advice: "WGSL's constants are finite numbers; compute it from a variable if infinity is meant",
        }),
        None => Ok(value),
    }
}

fn unary(op: UnaryOperator, value: Value) -> Option<Value> {
    value.map(|part| {
        Some(match (op, part) {
            (UnaryOperator::Negate, Literal::F32(value)) => Literal::F32(-value),
            (UnaryOperator::Negate, Literal::I32(value)) => Literal::I32(value.wrapping_neg()),
            (UnaryOperator::LogicalNot, Literal::Bool(value)) => Literal::Bool(!value),
            (UnaryOperator::BitwiseNot, Literal::I32(value)) => Literal::I32(!value),
            (UnaryOperator::BitwiseNot, Literal::U32(value)) => Literal::U32(!value),
            _ => return None,
        })
    })
}

fn binary(op: BinaryOperator, left: Option<Value>, right: Option<Value>) -> Evaluated {
    let Some(right) = right else {
        return Ok(None);
    };
    // For these operators, the right side alone decides whether the expression is valid.
    for part in right.components() {
        match (op, integer(*part)) {
            (BinaryOperator::Divide | BinaryOperator::Modulo, Some(0)) => {
                return Err(Refusal {
                    message: "an integer is divided by a constant that is 0".to_owned(),
                    advice: "divide by something else",
                });
            }
            (BinaryOperator::ShiftLeft | BinaryOperator::ShiftRight, Some(bits))
                if bits >= BITS =>
            {
                return Err(Refusal {
                    message: format!("a shift by {bits} bits"),
                    advice: "integers have 32 bits: shift by 0 to 31",
                });
            }
            _ => {}
        }
    }
    let Some(left) = left else {
        return Ok(None);
    };
    let value = left.zip(right, |left, right| binary_of_scalars(op, left, right))?;
    value
        .map(|value| finite(value, || "the result".to_owned()))
        .transpose()
}

pub(super) fn binary_of_scalars(
    op: BinaryOperator,
    left: Literal,
    right: Literal,
) -> Result<Option<Literal>, Refusal> {
    use BinaryOperator as Op;
    use Literal::{Bool, F32, I32, U32};
    let overflow = |what: &str| {
        Err(Refusal {
            message: format!("{what} of constants overflows"),
            advice: "choose smaller constants",
        })
    };
    Ok(Some(match (op, left, right) {
        (Op::Equal, ..) => Bool(left == right),
        (Op::NotEqual, ..) => Bool(left != right),
        (Op::Less | Op::LessEqual | Op::Greater | Op::GreaterEqual, ..) => {
            let (Some(left), Some(right)) = (number(left), number(right)) else {
                return Ok(None);
            };
            Bool(match op {
                Op::Less => left < right,
                Op::LessEqual => left <= right,
                Op::Greater => left > right,
                _ => left >= right,
            })
        }
        (_, Bool(a), Bool(b)) => Bool(match op {
            Op::And | Op::LogicalAnd => a && b,
            Op::InclusiveOr | Op::LogicalOr => a || b,
            _ => return Ok(None),
        }),
        (_, F32(a), F32(b)) => F32(match op {
            Op::Add => a + b,
            Op::Subtract => a - b,
            Op::Multiply => a * b,
            Op::Divide => a / b,
            Op::Modulo => a % b,
            _ => return Ok(None),
        }),
        (Op::ShiftLeft, I32(a), U32(b)) => match a.wrapping_shl(b) {
            // Valid only if all bits shifted out equal the sign bit.
            shifted if shifted >> b == a => I32(shifted),
            _ => return overflow("a shift"),
        },
        (Op::ShiftLeft, U32(a), U32(b)) => match a.wrapping_shl(b) {
            shifted if shifted >> b == a => U32(shifted),
            _ => return overflow("a shift"),
        },
        (Op::ShiftRight, I32(a), U32(b)) => I32(a.wrapping_shr(b)),
        (_, I32(a), I32(b)) => I32(match op {
            Op::Add => a.wrapping_add(b),
            Op::Subtract => a.wrapping_sub(b),
            Op::Multiply => a.wrapping_mul(b),
            Op::Divide | Op::Modulo => {
                let result = match op {
                    Op::Divide => a.checked_div(b),
                    _ => a.checked_rem(b),
                };
                match result {
                    Some(result) => result,
                    None => return overflow("a division"),
                }
            }
            Op::And => a & b,
            Op::InclusiveOr => a | b,
            Op::ExclusiveOr => a ^ b,
            _ => return Ok(None),
        }),
        (_, U32(a), U32(b)) => U32(match op {
            Op::Add => a.wrapping_add(b),
            Op::Subtract => a.wrapping_sub(b),
            Op::Multiply => a.wrapping_mul(b),
            // Division by zero was refused above.
            Op::Divide => a.checked_div(b).unwrap_or(0),
            Op::Modulo => a.checked_rem(b).unwrap_or(0),
            Op::And => a & b,
            Op::InclusiveOr => a | b,
            Op::ExclusiveOr => a ^ b,
            Op::ShiftRight => a.wrapping_shr(b),
            _ => return Ok(None),
        }),
        _ => return Ok(None),
    }))
}

pub(super) fn refuse<T>(message: String, advice: &'static str) -> Result<T, Refusal> {
    Err(Refusal { message, advice })
}

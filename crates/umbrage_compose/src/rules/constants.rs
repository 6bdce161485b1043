//! Constants out of range: what WGSL refuses where some arguments are constants, others not, and what naga
//! does not evaluate. Overrides count with their defaults: so does a pipeline that gives them no value.
//!
//! Naga evaluates what is constant through and through, and refuses what it finds there. What it knows no value
//! of stays in its IR as it was written, and so does what has but some arguments constant.

use half::f16;
use naga::{
    BinaryOperator, Expression, Function, Handle, Literal, MathFunction, Module, Override,
    RelationalFunction, Scalar, Span, TypeInner, UnaryOperator, front::Typifier,
    proc::ResolveContext,
};

use super::{
    Problem,
    value::{Value, converted, integer, length, number, recast, written},
};

/// Bits of WGSL's integers.
const BITS: i64 = 32;

/// Constant values of the module's own expressions, by their numbers.
pub(super) struct Constants<'a> {
    module: &'a Module,
    values: Vec<Option<Value>>,
}

/// Why an expression has no value: what is wrong, and what to do.
struct Refusal {
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

type Evaluated = Result<Option<Value>, Refusal>;

impl<'a> Constants<'a> {
    /// Evaluates the module's own expressions.
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

    /// The whole number that the module's own expression `handle` has.
    pub(super) fn integer(&self, handle: Handle<Expression>) -> Option<i64> {
        integer(self.values.get(handle.index()).copied()??.component(0))
    }

    /// The default of `item`.
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
            // What a `let` names is no constant, whatever it is; `_ = 1;` names nothing.
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
            // Naga's validator says why.
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

    /// The value of `expression`, where it is constant and we know how; `get` tells its operands'.
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

/// Checks by how many texels a fetch is moved.
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

fn finite(value: Value, what: impl Fn() -> String) -> Result<Value, Refusal> {
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
    // Of these, the right side alone decides whether they may stand.
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

fn binary_of_scalars(
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
            // Every bit that is shifted out equals the sign.
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
            // Zero was refused before.
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

fn refuse<T>(message: String, advice: &'static str) -> Result<T, Refusal> {
    Err(Refusal { message, advice })
}

/// The value of `fun`; refused where its constant arguments cannot be.
fn math(fun: MathFunction, args: [Option<Value>; 4]) -> Evaluated {
    let name = format!("`{}`", wgsl_name(fun));
    let untyped = |value: &Value| {
        let first = value.component(0);
        matches!(first, Literal::AbstractInt(_) | Literal::AbstractFloat(_))
    };
    if args.iter().flatten().any(untyped) {
        return refuse(
            format!("naga does not evaluate {name} of constants without a type"),
            "give an argument a type, as in `1.0f`",
        );
    }
    match (fun, args) {
        (MathFunction::Clamp, [_, Some(low), Some(high), _]) => {
            for (low, high) in pairs(low, high) {
                if number(low) > number(high) {
                    return refuse(
                        format!(
                            "{name} from {} to {}, which is less",
                            written(low),
                            written(high)
                        ),
                        "give the lower bound first",
                    );
                }
            }
        }
        (MathFunction::SmoothStep, [Some(low), Some(high), _, _]) => {
            for (low, high) in pairs(low, high) {
                if number(low).is_some() && number(low) == number(high) {
                    return refuse(
                        format!("{name} from {} to the same", written(low)),
                        "let its bounds differ; `step` has one alone",
                    );
                }
                if let (Literal::F32(low), Literal::F32(high)) = (low, high)
                    && !(high - low).is_finite()
                {
                    return refuse(
                        format!("{name} from {low:?} to {high:?}, which is too far"),
                        "let its bounds lie closer together",
                    );
                }
            }
        }
        (MathFunction::ExtractBits, [_, Some(offset), Some(count), _])
        | (MathFunction::InsertBits, [_, _, Some(offset), Some(count)]) => {
            let (offset, count) = (integer(offset.component(0)), integer(count.component(0)));
            if let (Some(offset), Some(count)) = (offset, count)
                && offset + count > BITS
            {
                return refuse(
                    format!("{name} of {count} bits from bit {offset} on"),
                    "integers have 32 bits: offset and count together are 32 at the most",
                );
            }
        }
        (MathFunction::Ldexp, [_, Some(exponent), _, _]) => {
            for part in exponent.components() {
                if integer(*part).is_some_and(|exponent| exponent > 128) {
                    return refuse(
                        format!("{name} by the exponent {}", written(*part)),
                        "the exponent of an `f32` is 128 at the most",
                    );
                }
            }
        }
        (MathFunction::QuantizeToF16 | MathFunction::Pack2x16float, [Some(value), ..]) => {
            for part in value.components() {
                if number(*part).is_some_and(|value| value.abs() > f64::from(f16::MAX)) {
                    return refuse(
                        format!("{name} of {}, which no `f16` can hold", written(*part)),
                        "an `f16` holds values from -65504 to 65504",
                    );
                }
            }
        }
        (MathFunction::Unpack2x16float, [Some(value), ..]) => {
            if let Literal::U32(bits) = value.component(0)
                && [bits & 0x7c00, bits >> 16 & 0x7c00].contains(&0x7c00)
            {
                return refuse(
                    format!("{name} of {bits:#x}, which holds no finite `f16`"),
                    "an exponent of all ones is infinity or no number",
                );
            }
        }
        _ => {}
    }
    let known: Vec<_> = args.iter().flatten().copied().collect();
    if known.len() != fun.argument_count() {
        return Ok(None);
    }
    let value = match (fun, known.as_slice()) {
        (MathFunction::ExtractBits, [value, offset, count]) => {
            let (offset, count) = (offset.component(0), count.component(0));
            value.map(|part| extract(part, offset, count))
        }
        (MathFunction::Min | MathFunction::Max, [a, b]) => {
            let least = fun == MathFunction::Min;
            a.zip(*b, |a, b| Ok(chosen(a, b, least)))?
        }
        (MathFunction::Clamp, [value, low, high]) => {
            let raised = value.zip(*low, |value, low| Ok(chosen(value, low, false)))?;
            match raised {
                Some(raised) => raised.zip(*high, |value, high| Ok(chosen(value, high, true)))?,
                None => None,
            }
        }
        (MathFunction::Pow, [base, exponent]) => base.zip(*exponent, |base, exponent| {
            let (Literal::F32(base), Literal::F32(exponent)) = (base, exponent) else {
                return Ok(None);
            };
            if base < 0.0 || (base == 0.0 && exponent <= 0.0) {
                return refuse(
                    format!("{name} of {base:?} and {exponent:?}"),
                    "it is defined of positive bases",
                );
            }
            Ok(Some(Literal::F32(base.powf(exponent))))
        })?,
        (MathFunction::Step, [edge, value]) => edge.zip(*value, |edge, value| {
            let (Some(edge), Some(value)) = (number(edge), number(value)) else {
                return Ok(None);
            };
            Ok(Some(Literal::F32(if edge <= value { 1.0 } else { 0.0 })))
        })?,
        (MathFunction::Dot, [a, b]) => sum_of_products(*a, *b),
        (MathFunction::Length, [value]) => length_of(*value),
        (MathFunction::Distance, [a, b]) => {
            let difference = a.zip(*b, |a, b| binary_of_scalars(BinaryOperator::Subtract, a, b))?;
            difference.and_then(length_of)
        }
        (MathFunction::Normalize, [value]) => match length_of(*value)
            .map(|length| finite(length, || format!("{name} of constants")))
            .transpose()?
            .map(|length| length.component(0))
        {
            Some(Literal::F32(0.0)) => {
                return refuse(
                    format!("{name} of zeros"),
                    "a vector of length 0 has no direction",
                );
            }
            Some(length) => value.zip(Value::scalar(length), |part, length| {
                binary_of_scalars(BinaryOperator::Divide, part, length)
            })?,
            None => None,
        },
        (MathFunction::QuantizeToF16, [value]) => value.map(|part| match part {
            Literal::F32(value) => Some(Literal::F32(f16::from_f32(value).to_f32())),
            _ => None,
        }),
        (MathFunction::Pack2x16float, [value]) => match [value.component(0), value.component(1)] {
            [Literal::F32(low), Literal::F32(high)] => {
                let [low, high] = [low, high].map(|part| f16::from_f32(part).to_bits());
                let packed = u32::from(high) << 16 | u32::from(low);
                Some(Value::scalar(Literal::U32(packed)))
            }
            _ => None,
        },
        (MathFunction::Unpack2x16float, [value]) => match value.component(0) {
            Literal::U32(bits) => {
                let halves = [bits as u16, (bits >> 16) as u16];
                Value::from_components(
                    &halves.map(|bits| Literal::F32(f16::from_bits(bits).to_f32())),
                )
            }
            _ => None,
        },
        (MathFunction::InsertBits, [value, new, offset, count]) => {
            let (offset, count) = (offset.component(0), count.component(0));
            value.zip(*new, |value, new| {
                Ok::<_, Refusal>(insert((value, new), offset, count))
            })?
        }
        (MathFunction::Ldexp, [value, exponent]) => value.zip(*exponent, |value, exponent| {
            Ok(match (value, exponent) {
                (Literal::F32(value), Literal::I32(exponent)) => Some(Literal::F32(
                    (f64::from(value) * f64::from(exponent.max(-300)).exp2()) as f32,
                )),
                _ => None,
            })
        })?,
        (MathFunction::Mix | MathFunction::Fma | MathFunction::SmoothStep, [a, b, c]) => {
            let length = [a, b, c].map(|part| part.components().len());
            let length = length.into_iter().max().unwrap_or(1);
            let joined: Option<Vec<_>> = (0..length)
                .map(|index| match [a, b, c].map(|part| part.component(index)) {
                    [Literal::F32(a), Literal::F32(b), Literal::F32(c)] => {
                        Some(Literal::F32(of_three(fun, a, b, c)))
                    }
                    _ => None,
                })
                .collect();
            joined.and_then(|joined| Value::from_components(&joined))
        }
        (_, [value]) => {
            let known = scalar_function(fun);
            let Some((function, domain)) = known else {
                return Ok(None);
            };
            for part in value.components() {
                if let Literal::F32(value) = part
                    && !domain.holds(*value)
                {
                    return refuse(
                        format!("{name} of {value:?}"),
                        "it is defined elsewhere alone; choose another constant",
                    );
                }
            }
            value.map(|part| match part {
                Literal::F32(value) => Some(Literal::F32(function(value.into()) as f32)),
                _ => None,
            })
        }
        _ => None,
    };
    value
        .map(|value| finite(value, || format!("{name} of constants")))
        .transpose()
}

/// The lesser of two, or the greater.
fn chosen(a: Literal, b: Literal, least: bool) -> Option<Literal> {
    let first = (number(a)? <= number(b)?) == least;
    Some(if first { a } else { b })
}

fn of_three(fun: MathFunction, a: f32, b: f32, c: f32) -> f32 {
    match fun {
        MathFunction::Mix => a * (1.0 - c) + b * c,
        MathFunction::Fma => a * b + c,
        _ => {
            let (way, whole) = (c - a, b - a);
            let part = way / whole;
            // What lies on the way must be a number as well.
            if [way, whole, part].iter().all(|number| number.is_finite()) {
                let part = part.clamp(0.0, 1.0);
                part * part * (3.0 - 2.0 * part)
            } else {
                f32::INFINITY
            }
        }
    }
}

fn sum_of_products(a: Value, b: Value) -> Option<Value> {
    let products = pairs(a, b).into_iter().map(|(a, b)| match (a, b) {
        (Literal::F32(a), Literal::F32(b)) => Some(a * b),
        _ => None,
    });
    let sum: Option<f32> = products.sum();
    Some(Value::scalar(Literal::F32(sum?)))
}

fn length_of(value: Value) -> Option<Value> {
    match value.components() {
        [Literal::F32(alone)] => Some(Value::scalar(Literal::F32(alone.abs()))),
        _ => sum_of_products(value, value)?.map(|squared| match squared {
            Literal::F32(squared) => Some(Literal::F32(squared.sqrt())),
            _ => None,
        }),
    }
}

fn insert((value, new): (Literal, Literal), offset: Literal, count: Literal) -> Option<Literal> {
    let (offset, count) = (integer(offset)? as u32, integer(count)? as u32);
    let mask = match count {
        0 => 0,
        count => (u32::MAX >> (32 - count)) << offset,
    };
    let inserted =
        |value: u32, new: u32| (value & !mask) | (new.checked_shl(offset).unwrap_or(0) & mask);
    Some(match (value, new) {
        (Literal::I32(value), Literal::I32(new)) => {
            Literal::I32(inserted(value as u32, new as u32) as i32)
        }
        (Literal::U32(value), Literal::U32(new)) => Literal::U32(inserted(value, new)),
        _ => return None,
    })
}

fn pairs(a: Value, b: Value) -> Vec<(Literal, Literal)> {
    let length = a.components().len().max(b.components().len());
    (0..length)
        .map(|index| (a.component(index), b.component(index)))
        .collect()
}

fn extract(value: Literal, offset: Literal, count: Literal) -> Option<Literal> {
    let (offset, count) = (integer(offset)? as u32, integer(count)? as u32);
    if count == 0 {
        return Some(match value {
            Literal::I32(_) => Literal::I32(0),
            _ => Literal::U32(0),
        });
    }
    let above = 32 - offset - count;
    Some(match value {
        Literal::I32(value) => Literal::I32(value << above >> (above + offset)),
        Literal::U32(value) => Literal::U32(value << above >> (above + offset)),
        _ => return None,
    })
}

/// Where a function is defined.
enum Domain {
    Everywhere,
    Positive,
    NotNegative,
    /// From -1 to 1.
    Unit,
    /// Between -1 and 1, both excluded.
    OpenUnit,
    /// From 1 on.
    FromOne,
}

impl Domain {
    fn holds(&self, value: f32) -> bool {
        match self {
            Self::Everywhere => true,
            Self::Positive => value > 0.0,
            Self::NotNegative => value >= 0.0,
            Self::Unit => value.abs() <= 1.0,
            Self::OpenUnit => value.abs() < 1.0,
            Self::FromOne => value >= 1.0,
        }
    }
}

/// Functions of one number, which naga evaluates itself but of an override.
fn scalar_function(fun: MathFunction) -> Option<(fn(f64) -> f64, Domain)> {
    use MathFunction as F;
    Some(match fun {
        F::Abs => (f64::abs, Domain::Everywhere),
        F::Ceil => (f64::ceil, Domain::Everywhere),
        F::Floor => (f64::floor, Domain::Everywhere),
        F::Trunc => (f64::trunc, Domain::Everywhere),
        F::Fract => (|x| x - x.floor(), Domain::Everywhere),
        F::Round => (f64::round_ties_even, Domain::Everywhere),
        F::Saturate => (|x| x.clamp(0.0, 1.0), Domain::Everywhere),
        F::Sin => (f64::sin, Domain::Everywhere),
        F::Cos => (f64::cos, Domain::Everywhere),
        F::Tan => (f64::tan, Domain::Everywhere),
        F::Sinh => (f64::sinh, Domain::Everywhere),
        F::Cosh => (f64::cosh, Domain::Everywhere),
        F::Tanh => (f64::tanh, Domain::Everywhere),
        F::Atan => (f64::atan, Domain::Everywhere),
        F::Asinh => (f64::asinh, Domain::Everywhere),
        F::Exp => (f64::exp, Domain::Everywhere),
        F::Exp2 => (f64::exp2, Domain::Everywhere),
        F::Radians => (f64::to_radians, Domain::Everywhere),
        F::Degrees => (f64::to_degrees, Domain::Everywhere),
        F::Log => (f64::ln, Domain::Positive),
        F::Log2 => (f64::log2, Domain::Positive),
        F::InverseSqrt => (|x| 1.0 / x.sqrt(), Domain::Positive),
        F::Sqrt => (f64::sqrt, Domain::NotNegative),
        F::Acos => (f64::acos, Domain::Unit),
        F::Asin => (f64::asin, Domain::Unit),
        F::Atanh => (f64::atanh, Domain::OpenUnit),
        F::Acosh => (f64::acosh, Domain::FromOne),
        _ => return None,
    })
}

fn wgsl_name(fun: MathFunction) -> String {
    let name = match fun {
        MathFunction::Pack2x16float => "pack2x16float",
        MathFunction::Unpack2x16float => "unpack2x16float",
        MathFunction::QuantizeToF16 => "quantizeToF16",
        MathFunction::SmoothStep => "smoothstep",
        _ => "",
    };
    if !name.is_empty() {
        return name.to_owned();
    }
    // Naga's names are WGSL's, but for the first letter.
    let debug = format!("{fun:?}");
    let mut letters = debug.chars();
    match letters.next() {
        Some(first) => first.to_lowercase().chain(letters).collect(),
        None => debug,
    }
}

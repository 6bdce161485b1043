//! Built-in functions with constant arguments: which arguments are invalid, and the results.

use half::f16;
use naga::{BinaryOperator, Literal, MathFunction};

use super::{
    constants::{BITS, Evaluated, Refusal, binary_of_scalars, finite, refuse},
    value::{Value, integer, number, written},
};

/// Value of `fun`; refused where its constant arguments are invalid.
pub(super) fn math(fun: MathFunction, args: [Option<Value>; 4]) -> Evaluated {
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
    in_range(fun, &name, args)?;
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

/// Checks for constant arguments that are invalid whatever the other arguments are.
fn in_range(fun: MathFunction, name: &str, args: [Option<Value>; 4]) -> Result<(), Refusal> {
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
    Ok(())
}

/// Smaller of the two values where `least`, otherwise the larger.
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
            // Intermediate results must be finite as well.
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

/// Domain of a function.
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

type OfNumber = fn(f64) -> f64;

/// Functions of one number. Naga evaluates them itself, unless the argument is an override.
fn scalar_function(fun: MathFunction) -> Option<(OfNumber, Domain)> {
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
    // Naga's names are WGSL's, except for the case of the first letter.
    let debug = format!("{fun:?}");
    let mut letters = debug.chars();
    match letters.next() {
        Some(first) => first.to_lowercase().chain(letters).collect(),
        None => debug,
    }
}

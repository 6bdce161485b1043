//! Values of constant expressions: scalars and vectors.

use naga::{Literal, Module, Scalar, ScalarKind, Type, TypeInner};

/// A scalar, or a vector with its components.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Value {
    length: usize,
    components: [Literal; 4],
}

impl Value {
    pub(super) fn scalar(literal: Literal) -> Self {
        Self {
            length: 1,
            components: [literal; 4],
        }
    }

    /// Value of one to four components.
    pub(super) fn from_components(all: &[Literal]) -> Option<Self> {
        let mut components = [*all.first()?; 4];
        components.get_mut(..all.len())?.copy_from_slice(all);
        Some(Self {
            length: all.len(),
            components,
        })
    }

    /// Zero value of the type `ty`; none where `ty` is neither a scalar nor a vector.
    pub(super) fn zero(ty: &Type) -> Option<Self> {
        match ty.inner {
            TypeInner::Scalar(scalar) => Literal::zero(scalar).map(Self::scalar),
            TypeInner::Vector { size, scalar } => {
                Literal::zero(scalar).map(|zero| Self::scalar(zero).splat(size as usize))
            }
            _ => None,
        }
    }

    pub(super) fn splat(self, length: usize) -> Self {
        Self {
            length,
            components: [self.components[0]; 4],
        }
    }

    pub(super) fn components(&self) -> &[Literal] {
        &self.components[..self.length]
    }

    /// Component `index` of a vector; of a scalar, the scalar itself for any index.
    pub(super) fn component(&self, index: usize) -> Literal {
        self.components[if self.length == 1 { 0 } else { index.min(3) }]
    }

    /// Applies `change` to each component.
    pub(super) fn map(self, change: impl Fn(Literal) -> Option<Literal>) -> Option<Self> {
        let changed: Option<Vec<_>> = self.components().iter().map(|c| change(*c)).collect();
        Self::from_components(&changed?)
    }

    /// Combines the components of both by `join`; a scalar is repeated for each component of a vector.
    pub(super) fn zip<E>(
        self,
        other: Self,
        join: impl Fn(Literal, Literal) -> Result<Option<Literal>, E>,
    ) -> Result<Option<Self>, E> {
        let length = self.length.max(other.length);
        let mut joined = Vec::with_capacity(length);
        for index in 0..length {
            match join(self.component(index), other.component(index))? {
                Some(literal) => joined.push(literal),
                None => return Ok(None),
            }
        }
        Ok(Self::from_components(&joined))
    }
}

/// `literal` as a number; none for a bool.
pub(super) fn number(literal: Literal) -> Option<f64> {
    Some(match literal {
        Literal::F32(value) => value.into(),
        Literal::F16(value) => value.into(),
        Literal::F64(value) => value,
        Literal::I32(value) => value.into(),
        Literal::U32(value) => value.into(),
        Literal::I64(value) => value as f64,
        Literal::U64(value) => value as f64,
        _ => return None,
    })
}

/// `literal` as an integer.
pub(super) fn integer(literal: Literal) -> Option<i64> {
    match literal {
        Literal::I32(value) => Some(value.into()),
        Literal::U32(value) => Some(value.into()),
        _ => None,
    }
}

/// `literal` converted to `scalar`, as WGSL's value constructors do.
pub(super) fn converted(literal: Literal, scalar: Scalar) -> Option<Literal> {
    let value = match literal {
        Literal::Bool(value) => f64::from(u8::from(value)),
        other => number(other)?,
    };
    // Between integer types, the bits are kept; a float is truncated and clamped to the range of the type.
    Some(match (scalar.kind, scalar.width) {
        (ScalarKind::Bool, _) => Literal::Bool(value != 0.0),
        (ScalarKind::Float, 4) => Literal::F32(value as f32),
        (ScalarKind::Sint, 4) => match integer(literal) {
            Some(whole) => Literal::I32(whole as i32),
            None => Literal::I32(value as i32),
        },
        (ScalarKind::Uint, 4) => match integer(literal) {
            Some(whole) => Literal::U32(whole as u32),
            None => Literal::U32(value as u32),
        },
        _ => return None,
    })
}

/// `literal` bitcast to `kind`, which has four bytes as well.
pub(super) fn recast(literal: Literal, kind: ScalarKind) -> Option<Literal> {
    let bits = match literal {
        Literal::F32(value) => value.to_bits(),
        Literal::I32(value) => value as u32,
        Literal::U32(value) => value,
        _ => return None,
    };
    Some(match kind {
        ScalarKind::Float => Literal::F32(f32::from_bits(bits)),
        ScalarKind::Sint => Literal::I32(bits as i32),
        ScalarKind::Uint => Literal::U32(bits),
        _ => return None,
    })
}

/// `literal` as an author would write it.
pub(super) fn written(literal: Literal) -> String {
    match literal {
        Literal::Bool(value) => value.to_string(),
        Literal::I32(value) => value.to_string(),
        Literal::U32(value) => value.to_string(),
        Literal::F32(value) => format!("{value:?}"),
        other => number(other).map_or_else(String::new, |value| format!("{value:?}")),
    }
}

/// Number of elements that an index into `inner`, or into the type that it points to, may choose from; none where
/// it is known only at run time.
pub(super) fn length(module: &Module, inner: &TypeInner) -> Option<u32> {
    match *inner {
        TypeInner::Vector { size, .. }
        | TypeInner::ValuePointer {
            size: Some(size), ..
        } => Some(size as u32),
        TypeInner::Matrix { columns, .. } => Some(columns as u32),
        TypeInner::Array {
            size: naga::ArraySize::Constant(count),
            ..
        } => Some(count.get()),
        TypeInner::Pointer { base, .. } => length(module, &module.types[base].inner),
        _ => None,
    }
}

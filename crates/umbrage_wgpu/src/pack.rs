//! Lays constants out as a linked shader expects them.

use umbrage_compose::{Layout, MemberType, Scalar};
use umbrage_shadow::{Constants, Value};

/// Why constants do not fit a shader's block.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PackError {
    /// The shader reads a member that has no value.
    #[error("the shader reads `{member}`, but no value is given for it")]
    Missing {
        /// The member.
        member: String,
    },
    /// A value is NaN or infinite: no picture comes of it.
    #[error("the value for the shader's `{member}` is not finite")]
    NotFinite {
        /// The member.
        member: String,
    },
    /// A value is of another type than the member.
    #[error("the shader's `{member}` is {expected}, but the value given for it is {found}")]
    Mismatch {
        /// The member.
        member: String,
        /// Its type.
        expected: String,
        /// The value.
        found: String,
    },
    /// An array has another number of elements than the shader's.
    #[error(
        "the shader's `{member}` is {expected}, but the value given for it has {found} elements"
    )]
    Length {
        /// The member.
        member: String,
        /// Its type.
        expected: String,
        /// How many elements the value has.
        found: usize,
    },
}

impl PackError {
    /// The same of a value inside `name`.
    fn within(mut self, name: &str) -> Self {
        let (Self::Missing { member }
        | Self::NotFinite { member }
        | Self::Mismatch { member, .. }
        | Self::Length { member, .. }) = &mut self;
        let dot = match member.is_empty() || member.starts_with('[') {
            true => "",
            false => ".",
        };
        *member = format!("{name}{dot}{member}");
        self
    }
}

/// The bytes of a block of this layout: each member's value at the member's offset, zeros between.
/// Values that no member reads are left out.
///
/// # Errors
/// A member without a value, or with one that is not finite, of another type or of another length.
pub fn pack(layout: &Layout, constants: &Constants) -> Result<Vec<u8>, PackError> {
    let mut bytes = Vec::new();
    pack_into(&mut bytes, layout, constants)?;
    Ok(bytes)
}

/// The same, into a buffer whose bytes are replaced.
pub(crate) fn pack_into(
    bytes: &mut Vec<u8>,
    layout: &Layout,
    constants: &Constants,
) -> Result<(), PackError> {
    bytes.clear();
    bytes.resize(layout.size as usize, 0);
    put_members(bytes, 0, layout, constants)
}

/// The bytes of a storage buffer, zeros between elements and members. `layout` is what the reflection
/// says of the binding `name`: of a `run_time` array that of one element, and `value` is an array of
/// one element at the least.
///
/// # Errors
/// As [`pack`]'s; a run-time array without elements.
pub fn pack_buffer(
    name: &str,
    (layout, run_time): (&Layout, bool),
    value: &Value,
) -> Result<Vec<u8>, PackError> {
    let ty = match layout.members.as_slice() {
        [only] if only.name.is_empty() => only.ty.clone(),
        _ => MemberType::Struct(layout.clone()),
    };
    let (ty, size) = match run_time {
        true => {
            let array = MemberType::Array {
                element: Box::new(ty),
                count: 0,
                stride: layout.size,
            };
            (array, 0)
        }
        false => (ty, layout.size),
    };
    let mut bytes = vec![0; size as usize];
    put(&mut bytes, 0, &ty, value).map_err(|error| error.within(name))?;
    Ok(bytes)
}

fn put_members(
    bytes: &mut Vec<u8>,
    offset: usize,
    layout: &Layout,
    constants: &Constants,
) -> Result<(), PackError> {
    for member in &layout.members {
        let name = &member.name;
        let Some(value) = constants.get(name) else {
            let member = name.clone();
            return Err(PackError::Missing { member });
        };
        let at = offset + member.offset as usize;
        put(bytes, at, &member.ty, value).map_err(|error| error.within(name))?;
    }
    Ok(())
}

/// Puts a value at `offset`. Names in errors begin at the value itself: callers put before it what it is called.
fn put(
    bytes: &mut Vec<u8>,
    offset: usize,
    ty: &MemberType,
    value: &Value,
) -> Result<(), PackError> {
    match (ty, value) {
        (
            MemberType::Array {
                element,
                count,
                stride,
            },
            Value::Array(values),
        ) => {
            let (given, stride) = (values.len(), *stride as usize);
            // A run-time array has as many as there are, but never none.
            if given == 0 || (*count > 0 && given != *count as usize) {
                return Err(PackError::Length {
                    member: String::new(),
                    expected: describe(ty),
                    found: given,
                });
            }
            let end = offset + given * stride;
            bytes.resize(bytes.len().max(end), 0);
            for (index, value) in values.iter().enumerate() {
                put(bytes, offset + index * stride, element, value)
                    .map_err(|error| error.within(&format!("[{index}]")))?;
            }
            Ok(())
        }
        (MemberType::Struct(layout), Value::Struct(members)) => {
            put_members(bytes, offset, layout, members)
        }
        _ => {
            let words = words(ty, value).filter(|words| offset + words.len() <= bytes.len());
            let words = words.ok_or_else(|| PackError::Mismatch {
                member: String::new(),
                expected: describe(ty),
                found: short(value),
            })?;
            if !value.is_finite() {
                let member = String::new();
                return Err(PackError::NotFinite { member });
            }
            bytes[offset..offset + words.len()].copy_from_slice(words);
            Ok(())
        }
    }
}

/// The bytes of a value that lies in one piece; none where it is of another type.
fn words<'a>(ty: &MemberType, value: &'a Value) -> Option<&'a [u8]> {
    let vector = |components, scalar| MemberType::Vector { components, scalar };
    let (own, bytes) = match value {
        Value::F32(v) => (vector(1, Scalar::F32), bytemuck::bytes_of(v)),
        Value::U32(v) => (vector(1, Scalar::U32), bytemuck::bytes_of(v)),
        Value::Vec2(v) => (vector(2, Scalar::F32), bytemuck::bytes_of(v)),
        Value::Vec3(v) => (vector(3, Scalar::F32), bytemuck::bytes_of(v)),
        Value::Vec4(v) => (vector(4, Scalar::F32), bytemuck::bytes_of(v)),
        Value::Mat4(v) => {
            let (columns, rows) = (4, 4);
            (MemberType::Matrix { columns, rows }, bytemuck::bytes_of(v))
        }
        Value::Array(_) | Value::Struct(_) => return None,
    };
    (own == *ty).then_some(bytes)
}

fn describe(ty: &MemberType) -> String {
    match ty {
        MemberType::Vector {
            components: 1,
            scalar,
        } => format!("{scalar:?}").to_lowercase(),
        MemberType::Vector { components, scalar } => {
            format!("vec{components}<{}>", format!("{scalar:?}").to_lowercase())
        }
        MemberType::Matrix { columns, rows } => format!("mat{columns}x{rows}f"),
        MemberType::Array {
            element, count: 0, ..
        } => format!("array<{}> of one element at the least", describe(element)),
        MemberType::Array { element, count, .. } => {
            format!("array<{}, {count}>", describe(element))
        }
        MemberType::Struct(_) => "a struct".to_owned(),
    }
}

fn short(value: &Value) -> String {
    match value {
        Value::Array(values) => format!("an array of {}", values.len()),
        Value::Struct(_) => "a struct".to_owned(),
        value => format!("{value:?}").replace('\n', " "),
    }
}

#[cfg(test)]
mod tests {
    use glam::{Vec2, Vec3};
    use umbrage_compose::Member;

    use super::*;

    fn layout() -> Layout {
        let vector = |components| MemberType::Vector {
            components,
            scalar: Scalar::F32,
        };
        let member = |name: &str, offset, size, ty| Member {
            name: name.to_owned(),
            offset,
            size,
            ty,
        };
        let array = MemberType::Array {
            element: Box::new(vector(2)),
            count: 2,
            stride: 16,
        };
        Layout {
            size: 48,
            members: vec![
                member("direction", 0, 12, vector(3)),
                member("range", 12, 4, vector(1)),
                member("offsets", 16, 32, array),
            ],
        }
    }

    fn constants() -> Constants {
        let offsets = vec![
            Value::Vec2(Vec2::new(5.0, 6.0)),
            Value::Vec2(Vec2::new(7.0, 8.0)),
        ];
        Constants::new()
            .with("unread", Value::U32(9))
            .with("range", Value::F32(4.0))
            .with("direction", Value::Vec3(Vec3::new(1.0, 2.0, 3.0)))
            .with("offsets", Value::Array(offsets))
    }

    #[test]
    fn numbers_that_are_none_are_refused() {
        let constants = Constants::new().with("range", Value::F32(f32::NAN));
        let constants = constants.with("direction", Value::Vec3(Vec3::ONE));
        let refused = pack(&layout(), &constants).expect_err("NaN is no range");
        let member = "range".to_owned();
        assert_eq!(refused, PackError::NotFinite { member });
    }

    #[test]
    fn values_lie_at_their_members_offsets() {
        let bytes = pack(&layout(), &constants()).expect("fits");
        let floats: Vec<f32> = bytes
            .chunks_exact(4)
            .map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
            .collect();
        assert_eq!(
            floats,
            [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 0.0, 0.0, 7.0, 8.0, 0.0, 0.0]
        );
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let missing = pack(&layout(), &Constants::new()).expect_err("missing");
        assert_eq!(
            missing.to_string(),
            "the shader reads `direction`, but no value is given for it"
        );
        let wrong = Constants::new().with("direction", Value::U32(1));
        let mismatch = pack(&layout(), &wrong).expect_err("mismatch");
        assert_eq!(
            mismatch.to_string(),
            "the shader's `direction` is vec3<f32>, but the value given for it is U32(1)"
        );
    }
}

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
}

/// The bytes of a block of this layout: each member's value at the member's offset, zeros between.
/// Values that no member reads are left out.
///
/// # Errors
/// A member without a value, or with one that is not finite or of another type.
pub fn pack(layout: &Layout, constants: &Constants) -> Result<Vec<u8>, PackError> {
    let mut bytes = vec![0; layout.size as usize];
    for member in &layout.members {
        let name = &member.name;
        let value = constants.get(name).ok_or_else(|| PackError::Missing {
            member: name.clone(),
        })?;
        if !value.is_finite() {
            return Err(PackError::NotFinite {
                member: name.clone(),
            });
        }
        put(&mut bytes, member.offset as usize, &member.ty, value).ok_or_else(|| {
            PackError::Mismatch {
                member: name.clone(),
                expected: describe(&member.ty),
                found: short(value),
            }
        })?;
    }
    Ok(bytes)
}

fn put(bytes: &mut [u8], offset: usize, ty: &MemberType, value: &Value) -> Option<()> {
    let mut write = |words: &[u8]| {
        bytes
            .get_mut(offset..offset + words.len())?
            .copy_from_slice(words);
        Some(())
    };
    match (ty, value) {
        (
            MemberType::Vector {
                components,
                scalar: Scalar::F32,
            },
            value,
        ) => match (components, value) {
            (1, Value::F32(v)) => write(bytemuck::bytes_of(v)),
            (2, Value::Vec2(v)) => write(bytemuck::bytes_of(v)),
            (3, Value::Vec3(v)) => write(bytemuck::bytes_of(v)),
            (4, Value::Vec4(v)) => write(bytemuck::bytes_of(v)),
            _ => None,
        },
        (
            MemberType::Vector {
                components: 1,
                scalar: Scalar::U32,
            },
            Value::U32(v),
        ) => write(bytemuck::bytes_of(v)),
        (
            MemberType::Matrix {
                columns: 4,
                rows: 4,
            },
            Value::Mat4(v),
        ) => write(bytemuck::bytes_of(v)),
        (
            MemberType::Array {
                element,
                count,
                stride,
            },
            Value::Array(values),
        ) => {
            if values.len() != *count as usize {
                return None;
            }
            for (index, value) in values.iter().enumerate() {
                put(bytes, offset + index * *stride as usize, element, value)?;
            }
            Some(())
        }
        _ => None,
    }
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
        MemberType::Array { element, count, .. } => {
            format!("array<{}, {count}>", describe(element))
        }
        MemberType::Struct(_) => "a struct".to_owned(),
    }
}

fn short(value: &Value) -> String {
    match value {
        Value::Array(values) => format!("an array of {}", values.len()),
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

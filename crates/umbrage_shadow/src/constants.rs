//! Constants for a shader's uniform block, by the names of its members.

use glam::{Mat4, Vec2, Vec3, Vec4};

/// A member's value.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// `f32`.
    F32(f32),
    /// `u32`.
    U32(u32),
    /// `vec2f`.
    Vec2(Vec2),
    /// `vec3f`.
    Vec3(Vec3),
    /// `vec4f`.
    Vec4(Vec4),
    /// `mat4x4f`.
    Mat4(Mat4),
    /// `array<…>`: all elements of one kind, and of an array of fixed size as many as it has. Vectors,
    /// matrices, structs and arrays may be elements, in uniform blocks and in storage buffers; where each lies is
    /// the renderer's to find.
    Array(Vec<Value>),
    /// A struct within a block, or as an element: its members' values by their names.
    Struct(Constants),
}

impl Value {
    /// Whether every number in it is finite.
    pub fn is_finite(&self) -> bool {
        match self {
            Self::F32(value) => value.is_finite(),
            Self::U32(_) => true,
            Self::Vec2(value) => value.is_finite(),
            Self::Vec3(value) => value.is_finite(),
            Self::Vec4(value) => value.is_finite(),
            Self::Mat4(value) => value.is_finite(),
            Self::Array(values) => values.iter().all(Self::is_finite),
            Self::Struct(Constants(members)) => members.iter().all(|(_, v)| v.is_finite()),
        }
    }
}

macro_rules! from {
    ($($kind:ident: $ty:ty),*) => {$(
        impl From<$ty> for Value {
            fn from(value: $ty) -> Self {
                Self::$kind(value)
            }
        }
    )*};
}

from!(F32: f32, U32: u32, Vec2: Vec2, Vec3: Vec3, Vec4: Vec4, Mat4: Mat4, Array: Vec<Value>, Struct: Constants);

/// Values by the name of the member that reads them. The renderer places each at the offset that the
/// linked shader gives it; a value that this permutation does not read is left out, and a member
/// without a value is an error.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Constants(Vec<(String, Value)>);

impl Constants {
    /// No values.
    pub fn new() -> Self {
        Self::default()
    }

    /// These and `value` for the member `name`.
    pub fn with(mut self, name: impl Into<String>, value: impl Into<Value>) -> Self {
        self.0.push((name.into(), value.into()));
        self
    }

    /// Adds `others`.
    pub fn extend(&mut self, others: Self) {
        self.0.extend(others.0);
    }

    /// The value for the member `name`.
    pub fn get(&self, name: &str) -> Option<&Value> {
        self.0
            .iter()
            .find(|(known, _)| known == name)
            .map(|(_, value)| value)
    }
}

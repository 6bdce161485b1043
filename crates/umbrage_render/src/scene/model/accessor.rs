//! Reads a glTF file's accessors; everything that they declare is checked.

use serde::Deserialize;

use super::{
    SceneError,
    document::{Document, Whole},
};

/// The most elements that an accessor may have without data for each: as zeros, they cost a file nothing.
const MOST_ZEROS: u64 = 1 << 24;

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Accessor {
    buffer_view: Option<Whole>,
    #[serde(default)]
    byte_offset: Whole,
    component_type: Whole,
    #[serde(default)]
    normalized: bool,
    count: Whole,
    #[serde(rename = "type")]
    kind: String,
    sparse: Option<Sparse>,
}

/// Elements that differ from what the buffer view says, or from zero where there is none.
#[derive(Deserialize)]
struct Sparse {
    count: Whole,
    indices: SparsePart,
    values: SparsePart,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct SparsePart {
    buffer_view: Whole,
    #[serde(default)]
    byte_offset: Whole,
    /// Of the indices alone.
    component_type: Option<Whole>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn of(number: Whole) -> Option<Self> {
        Some(match number.0 {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// The number that stands in `bytes`; 0 of whole numbers of 32 bits, which a float may not hold.
    fn float(self, bytes: &[u8], normalized: bool) -> f32 {
        let (value, most) = match (self, bytes) {
            (Self::I8, &[a]) => (f32::from(i8::from_le_bytes([a])), f32::from(i8::MAX)),
            (Self::U8, &[a]) => (f32::from(a), f32::from(u8::MAX)),
            (Self::I16, &[a, b]) => (f32::from(i16::from_le_bytes([a, b])), f32::from(i16::MAX)),
            (Self::U16, &[a, b]) => (f32::from(u16::from_le_bytes([a, b])), f32::from(u16::MAX)),
            (Self::F32, &[a, b, c, d]) => return f32::from_le_bytes([a, b, c, d]),
            _ => return 0.0,
        };
        if normalized {
            (value / most).max(-1.0)
        } else {
            value
        }
    }

    fn whole(self, bytes: &[u8]) -> u32 {
        match (self, bytes) {
            (Self::U8, &[a]) => u32::from(a),
            (Self::U16, &[a, b]) => u32::from(u16::from_le_bytes([a, b])),
            (Self::U32, &[a, b, c, d]) => u32::from_le_bytes([a, b, c, d]),
            _ => 0,
        }
    }

    /// The type's greatest number, which as an index would mean a primitive restart.
    fn greatest(self) -> u32 {
        match self {
            Self::U8 => u8::MAX.into(),
            Self::U16 => u16::MAX.into(),
            _ => u32::MAX,
        }
    }
}

/// Elements that stand in a buffer view, their range checked.
struct Elements<'a> {
    bytes: &'a [u8],
    stride: usize,
    size: usize,
    count: usize,
}

impl<'a> Elements<'a> {
    fn iter(&self) -> impl Iterator<Item = &'a [u8]> + use<'a> {
        let (bytes, stride, size) = (self.bytes, self.stride, self.size);
        (0..self.count).filter_map(move |i| bytes.get(i * stride..i * stride + size))
    }
}

impl Document<'_> {
    /// How many components an element of an accessor has, which `by` names.
    pub(super) fn width(&self, index: Whole, by: &str) -> Result<usize, SceneError> {
        let accessor: Accessor = self.element("accessors", index, by)?;
        width(&accessor.kind).ok_or_else(|| {
            let problem = format!("`{}` is no type of elements", accessor.kind);
            self.invalid(&format!("accessors[{}]", index.0), problem)
        })
    }

    /// Vectors of `N` finite numbers, or matrices of as many, by columns; of any type except 32-bit whole numbers;
    /// from −1 or 0 to 1 where they are normalised.
    pub(super) fn floats<const N: usize>(
        &self,
        index: Whole,
        by: &str,
    ) -> Result<Vec<[f32; N]>, SceneError> {
        let place = format!("accessors[{}]", index.0);
        let vectors = self.decode(index, by, N, |component, bytes, normalized| {
            let size = component.size();
            let part = |i: usize| bytes.get(i * size..(i + 1) * size).unwrap_or_default();
            let known = match N {
                16 => component == Component::F32,
                _ => component != Component::U32,
            };
            known.then(|| std::array::from_fn(|i| component.float(part(i), normalized)))
        })?;
        match vectors
            .iter()
            .position(|v: &[f32; N]| !v.iter().all(|x| x.is_finite()))
        {
            None => Ok(vectors),
            Some(element) => {
                let vector = vectors[element];
                let problem = format!("element {element} is {vector:?}, which is not finite");
                Err(self.invalid(&place, problem))
            }
        }
    }

    /// Tuples of `N` whole numbers.
    pub(super) fn wholes<const N: usize>(
        &self,
        index: Whole,
        by: &str,
    ) -> Result<Vec<[u32; N]>, SceneError> {
        self.decode(index, by, N, |component, bytes, _| {
            let size = component.size();
            let part = |i: usize| bytes.get(i * size..(i + 1) * size).unwrap_or_default();
            let known = matches!(component, Component::U8 | Component::U16 | Component::U32);
            known.then(|| std::array::from_fn(|i| component.whole(part(i))))
        })
    }

    /// Vertex numbers, each below `vertices`.
    pub(super) fn indices(
        &self,
        index: Whole,
        by: &str,
        vertices: usize,
    ) -> Result<Vec<u32>, SceneError> {
        let indices = self.wholes::<1>(index, by)?;
        let beyond = indices
            .iter()
            .position(|[vertex]| *vertex as usize >= vertices);
        let Some(element) = beyond else {
            return Ok(indices.into_iter().flatten().collect());
        };
        let [vertex] = indices[element];
        let accessor: Accessor = self.element("accessors", index, by)?;
        let mut problem =
            format!("element {element} names vertex {vertex}, but the mesh has {vertices}");
        if Component::of(accessor.component_type).is_some_and(|c| c.greatest() == vertex) {
            problem += "; glTF has no such number for a restart";
        }
        Err(self.invalid(&format!("accessors[{}]", index.0), problem))
    }

    /// The elements of an accessor of `width` components, by `decode`, which knows no element of some types.
    fn decode<T: Clone>(
        &self,
        index: Whole,
        by: &str,
        width: usize,
        decode: impl Fn(Component, &[u8], bool) -> Option<T>,
    ) -> Result<Vec<T>, SceneError> {
        let place = format!("accessors[{}]", index.0);
        let accessor: Accessor = self.element("accessors", index, by)?;
        if self::width(&accessor.kind) != Some(width) {
            let wanted = kind(width);
            let problem = format!("it is a {}, but {by} needs a {wanted}", accessor.kind);
            return Err(self.invalid(&place, problem));
        }
        let unknown = || {
            let number = accessor.component_type.0;
            let problem = format!("components of type {number} are not known for {by}");
            self.invalid(&place, problem)
        };
        let component = Component::of(accessor.component_type).ok_or_else(unknown)?;
        let size = width * component.size();
        let zero = decode(component, &[0; 64][..size], accessor.normalized).ok_or_else(unknown)?;
        let read = |bytes: &[u8]| decode(component, bytes, accessor.normalized);
        let mut values: Vec<T> = match accessor.buffer_view {
            Some(view) => {
                let part = (view, accessor.byte_offset, accessor.count);
                self.elements(part, size, &place)?
                    .iter()
                    .filter_map(read)
                    .collect()
            }
            None if accessor.count.0 > MOST_ZEROS => {
                let problem = format!(
                    "{} elements without data are more than {MOST_ZEROS}",
                    accessor.count.0
                );
                return Err(self.invalid(&place, problem));
            }
            None => vec![zero; accessor.count.place()],
        };
        let Some(sparse) = &accessor.sparse else {
            return Ok(values);
        };
        let number = sparse.indices.component_type.and_then(Component::of);
        let number = number
            .filter(|number| matches!(number, Component::U8 | Component::U16 | Component::U32));
        let number = number.ok_or_else(|| {
            self.invalid(
                &place,
                "its sparse indices are no whole numbers without a sign",
            )
        })?;
        let part = |part: &SparsePart| (part.buffer_view, part.byte_offset, sparse.count);
        let indices = self.elements(part(&sparse.indices), number.size(), &place)?;
        let others = self.elements(part(&sparse.values), size, &place)?;
        for (index, bytes) in indices.iter().zip(others.iter()) {
            let index = number.whole(index);
            let count = values.len();
            let Some(value) = values.get_mut(index as usize) else {
                let problem = format!("its sparse element {index} is beyond its {count}");
                return Err(self.invalid(&place, problem));
            };
            if let Some(other) = read(bytes) {
                *value = other;
            }
        }
        Ok(values)
    }

    /// `count` elements of `size` bytes from byte `offset` of a view.
    fn elements(
        &self,
        (view, offset, count): (Whole, Whole, Whole),
        size: usize,
        place: &str,
    ) -> Result<Elements<'_>, SceneError> {
        let (bytes, stride) = self.view(view, place)?;
        let stride = stride.unwrap_or(size);
        if stride < size {
            let problem = format!("elements of {size} bytes overlap at a stride of {stride}");
            return Err(self.invalid(place, problem));
        }
        let (offset, count) = (offset.0, count.0);
        let last = count.saturating_sub(1).checked_mul(stride as u64);
        let needed = last.and_then(|last| {
            let size = if count > 0 { size as u64 } else { 0 };
            last.checked_add(offset)?.checked_add(size)
        });
        let tail = usize::try_from(offset)
            .ok()
            .and_then(|offset| bytes.get(offset..));
        match tail {
            Some(bytes) if needed.is_some_and(|needed| needed <= offset + bytes.len() as u64) => {
                Ok(Elements {
                    bytes,
                    stride,
                    size,
                    count: count as usize,
                })
            }
            _ => {
                let problem = format!(
                    "{count} elements of {size} bytes from byte {offset} reach beyond \
                     bufferViews[{}], which has {} bytes",
                    view.0,
                    bytes.len()
                );
                Err(self.invalid(place, problem))
            }
        }
    }
}

const KINDS: [(&str, usize); 5] = [
    ("SCALAR", 1),
    ("VEC2", 2),
    ("VEC3", 3),
    ("VEC4", 4),
    ("MAT4", 16),
];

fn width(kind: &str) -> Option<usize> {
    let known = KINDS.iter().find(|(name, _)| *name == kind);
    known.map(|(_, width)| *width)
}

fn kind(width: usize) -> &'static str {
    let known = KINDS.iter().find(|(_, known)| *known == width);
    known.map_or("", |(name, _)| *name)
}

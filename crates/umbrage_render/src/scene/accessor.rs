//! Reads a glTF file's accessors, believing nothing that it says of itself.

use std::path::Path;

use gltf::json::{
    Accessor, Index, Root,
    accessor::{ComponentType, Type},
    buffer,
    validation::Checked,
};

use super::SceneError;

/// A glTF file's buffers.
pub(super) struct Buffers<'a> {
    pub(super) path: &'a Path,
    pub(super) root: &'a Root,
    pub(super) data: Vec<Vec<u8>>,
}

/// An accessor's elements, each `size` bytes within the view.
struct Elements<'a> {
    bytes: &'a [u8],
    stride: usize,
    size: usize,
    count: usize,
    component: ComponentType,
    normalized: bool,
}

impl Elements<'_> {
    fn iter(&self) -> impl Iterator<Item = &[u8]> {
        // The range was checked when the elements were found; `get` keeps that promise honest.
        (0..self.count).filter_map(|i| self.bytes.get(i * self.stride..i * self.stride + self.size))
    }
}

const REMEDY: &str = "export the model again";

impl Buffers<'_> {
    fn invalid(&self, place: &str, problem: impl Into<String>) -> SceneError {
        SceneError::invalid(self.path, place, problem, REMEDY)
    }

    /// The bytes of a buffer view, and its stride where it has one.
    pub(super) fn view(
        &self,
        index: Index<buffer::View>,
    ) -> Result<(&[u8], Option<usize>), SceneError> {
        let place = format!("bufferViews[{index}]");
        let view = self
            .root
            .get(index)
            .ok_or_else(|| self.invalid(&place, "no such view"))?;
        let data = self
            .data
            .get(view.buffer.value())
            .map_or(&[][..], Vec::as_slice);
        let start = view.byte_offset.unwrap_or_default().0;
        let bytes = start
            .checked_add(view.byte_length.0)
            .and_then(|end| data.get(usize::try_from(start).ok()?..usize::try_from(end).ok()?))
            .ok_or_else(|| {
                let problem = format!(
                    "{} bytes from byte {start} reach beyond buffer {}, which has {}",
                    view.byte_length.0,
                    view.buffer,
                    data.len()
                );
                self.invalid(&place, problem)
            })?;
        Ok((bytes, view.byte_stride.map(|stride| stride.0)))
    }

    fn elements(&self, index: Index<Accessor>, wanted: Type) -> Result<Elements<'_>, SceneError> {
        let place = format!("accessors[{index}]");
        let accessor = self
            .root
            .get(index)
            .ok_or_else(|| self.invalid(&place, "no such accessor"))?;
        let (Checked::Valid(component), Checked::Valid(found)) =
            (accessor.component_type, accessor.type_)
        else {
            return Err(self.invalid(&place, "its type is unknown"));
        };
        if found != wanted {
            return Err(self.invalid(
                &place,
                format!("it is a {found:?}, but a {wanted:?} is needed"),
            ));
        }
        if accessor.sparse.is_some() {
            return Err(self.invalid(&place, "sparse accessors are not supported"));
        }
        let view = accessor
            .buffer_view
            .ok_or_else(|| self.invalid(&place, "it has no buffer view"))?;
        let (bytes, stride) = self.view(view)?;
        let size = wanted.multiplicity() * component.0.size();
        let stride = stride.unwrap_or(size);
        if stride < size {
            let problem = format!("elements of {size} bytes overlap at a stride of {stride}");
            return Err(self.invalid(&place, problem));
        }
        let offset = accessor.byte_offset.unwrap_or_default().0;
        let count = accessor.count.0;
        let needed = count
            .saturating_sub(1)
            .checked_mul(stride as u64)
            .and_then(|last| last.checked_add(offset))
            .and_then(|start| start.checked_add(if count > 0 { size as u64 } else { 0 }));
        let tail = usize::try_from(offset)
            .ok()
            .and_then(|offset| bytes.get(offset..));
        let (Some(tail), true) = (tail, needed.is_some_and(|n| n <= bytes.len() as u64)) else {
            let problem = format!(
                "{count} elements of {size} bytes from byte {offset} reach beyond bufferViews[{view}], \
                 which has {} bytes",
                bytes.len()
            );
            return Err(self.invalid(&place, problem));
        };
        Ok(Elements {
            bytes: tail,
            stride,
            size,
            count: count as usize,
            component: component.0,
            normalized: accessor.normalized,
        })
    }

    /// Vectors of `N` finite floats; whole numbers only where they are normalised.
    pub(super) fn vectors<const N: usize>(
        &self,
        index: Index<Accessor>,
    ) -> Result<Vec<[f32; N]>, SceneError> {
        let wanted = [Type::Scalar, Type::Vec2, Type::Vec3, Type::Vec4][N - 1];
        let elements = self.elements(index, wanted)?;
        let scale = match (elements.component, elements.normalized) {
            (ComponentType::F32, _) => 1.0,
            (ComponentType::U8, true) => 1.0 / 255.0,
            (ComponentType::U16, true) => 1.0 / 65535.0,
            (component, _) => {
                let problem = format!("components of type {component:?} are not supported here");
                return Err(self.invalid(&format!("accessors[{index}]"), problem));
            }
        };
        let mut vectors = Vec::with_capacity(elements.count);
        for bytes in elements.iter() {
            let size = elements.component.size();
            let vector = std::array::from_fn(|i| match bytes[i * size..(i + 1) * size] {
                [a] => f32::from(a) * scale,
                [a, b] => f32::from(u16::from_le_bytes([a, b])) * scale,
                [a, b, c, d] => f32::from_le_bytes([a, b, c, d]),
                _ => 0.0,
            });
            if !vector.iter().all(|x| x.is_finite()) {
                let problem = format!(
                    "element {} is {vector:?}, which is not finite",
                    vectors.len()
                );
                return Err(self.invalid(&format!("accessors[{index}]"), problem));
            }
            vectors.push(vector);
        }
        Ok(vectors)
    }

    /// Vertex numbers, each below `vertices`.
    pub(super) fn indices(
        &self,
        index: Index<Accessor>,
        vertices: usize,
    ) -> Result<Vec<u32>, SceneError> {
        let elements = self.elements(index, Type::Scalar)?;
        let mut indices = Vec::with_capacity(elements.count);
        for bytes in elements.iter() {
            let value = match (elements.component, bytes) {
                (ComponentType::U8, &[a]) => u32::from(a),
                (ComponentType::U16, &[a, b]) => u32::from(u16::from_le_bytes([a, b])),
                (ComponentType::U32, &[a, b, c, d]) => u32::from_le_bytes([a, b, c, d]),
                (component, _) => {
                    let problem = format!("components of type {component:?} cannot be indices");
                    return Err(self.invalid(&format!("accessors[{index}]"), problem));
                }
            };
            if value as usize >= vertices {
                let problem = format!(
                    "element {} names vertex {value}, but the mesh has {vertices}",
                    indices.len()
                );
                return Err(self.invalid(&format!("accessors[{index}]"), problem));
            }
            indices.push(value);
        }
        Ok(indices)
    }
}

//! Sides of casters that no light sees.

use glam::{DVec3, DVec4};
use umbrage_shadow::{Aabb, CasterPass, Cull};
use wgpu::{CompareFunction, Face};

/// Properties that tell which sides of a caster a light can see.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sides {
    /// Whether its transform mirrors: its fronts are wound the other way then.
    pub mirrored: bool,
    /// Whether its triangles bound solids, all fronts outwards and without holes: its backs are seen from nowhere outside.
    pub closed: bool,
}

impl Sides {
    /// Those of a solid that is not mirrored.
    pub const SOLID: Self = Self {
        mirrored: false,
        closed: true,
    };
}

/// The face that `pass` leaves out of closed casters, for casters in these boxes, relative to `origin`; none where both may be
/// seen.
pub(crate) fn hidden<'a>(
    pass: &CasterPass,
    mut casters: impl Iterator<Item = &'a Aabb>,
    origin: DVec3,
) -> Option<Face> {
    let depth = pass.depth.as_ref().filter(|_| pass.cull == Cull::Hidden)?;
    let rows = pass.view_proj.as_dmat4().transpose();
    let (x, y, z, w) = (rows.x_axis, rows.y_axis, rows.z_axis, rows.w_axis);
    // Before this plane nothing is drawn, so that a caster which it cuts is open there.
    let near = match depth.compare {
        CompareFunction::Greater | CompareFunction::GreaterEqual => w - z,
        CompareFunction::Less | CompareFunction::LessEqual => z,
        _ => return None,
    };
    let whole = |aabb: &Aabb| {
        let (center, half) = (
            (aabb.min + aabb.max) / 2.0 - origin,
            (aabb.max - aabb.min) / 2.0,
        );
        let farther = near.truncate().abs();
        let nearest = near.dot(center.extend(1.0)) - farther.dot(half);
        // Vertices are transformed in 32 bits.
        nearest > rounding(near, center, half)
    };
    if !casters.all(whole) {
        return None;
    }
    // A face is turned to the light where its normal points against the way that depths recede.
    let turned = -x.truncate().cross(y.truncate()).dot(near.truncate());
    match turned {
        turned if turned > 0.0 => Some(Face::Back),
        turned if turned < 0.0 => Some(Face::Front),
        _ => None,
    }
}

/// Bound of what 32 bits may be off in a row's product with a point of a box.
fn rounding(row: DVec4, center: DVec3, half: DVec3) -> f64 {
    let most = row.truncate().abs().dot(center.abs() + half) + row.w.abs();
    // Four products and sums, twice: to the world, and to clip space.
    8.0 * f64::from(f32::EPSILON) * most
}

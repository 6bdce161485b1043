//! How normals go through transforms.

use glam::DMat3;

/// Takes normals through `linear`: its inverse transpose, but for a positive factor. Made of
/// cofactors, which exist for flattened objects too.
pub(crate) fn normal_matrix(linear: DMat3) -> DMat3 {
    let [a, b, c] = [linear.x_axis, linear.y_axis, linear.z_axis];
    let cofactors = DMat3::from_cols(b.cross(c), c.cross(a), a.cross(b));
    let largest = cofactors
        .to_cols_array()
        .into_iter()
        .fold(0.0, |most, x| x.abs().max(most));
    let sign = if linear.determinant() < 0.0 {
        -1.0
    } else {
        1.0
    };
    if largest > 0.0 {
        cofactors * (sign / largest)
    } else {
        cofactors
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    #[test]
    fn normals_stay_upright_on_their_surfaces() {
        let linear = DMat3::from_cols_array(&[-2.0, 0.3, 0.0, 0.1, 0.5, 0.0, 0.0, 0.7, 3.0]);
        let (u, v) = (DVec3::new(0.2, 1.0, 0.4), DVec3::new(-0.6, 0.1, 0.9));
        let normal = normal_matrix(linear) * u.cross(v);
        assert!(normal.dot(linear * u).abs() < 1e-12 && normal.dot(linear * v).abs() < 1e-12);
        // A mirrored normal stays on the same side of its surface.
        assert!((linear * u.cross(v)).dot(normal) > 0.0);
        // A normal that pointed up still does when the object is flattened onto the ground.
        let flat = DMat3::from_diagonal(DVec3::new(1.0, 0.0, 1.0));
        assert_eq!(normal_matrix(flat) * DVec3::Y, DVec3::Y);
    }
}

//! The camera.

use glam::{DMat3, DMat4, DQuat, DVec2, DVec3, DVec4};

use crate::{Frustum, PlanError};

/// A camera: world space, metres, right-handed, y up; it looks along −z of its own axes.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// Where it stands: what camera-relative positions are relative to, and view depths are counted from.
    pub position: DVec3,
    /// From its axes to the world's.
    pub rotation: DQuat,
    /// How it projects.
    pub projection: Projection,
    /// The view depth (metres) that distances of settings are counted from, such as how far shadows are to be seen: 0 for
    /// a perspective view. An orthographic one may [stand anywhere](Self::around) along its axis; there it is where its
    /// camera stands.
    pub eye: f64,
}

/// How a camera projects. Clip space is WebGPU's, depth reversed: 1 at `near`, 0 at `far`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection {
    /// Field of view.
    pub field: Field,
    /// Width over height.
    pub aspect: f64,
    /// Metres, above 0.
    pub near: f64,
    /// Metres, above `near`.
    pub far: f64,
}

/// Field of view of a camera: whether its rays spread, and how far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Field {
    /// Rays from one point.
    Perspective {
        /// Full vertical angle, radians.
        fov_y: f64,
    },
    /// Parallel rays: things look as large from anywhere.
    Orthographic {
        /// From the picture's lower to its upper edge, metres.
        height: f64,
    },
}

impl View {
    /// A perspective view from `position` along `forward`, y as far up as can be, that sees `fov_y` (radians) from bottom to
    /// top, `aspect` times as much across, and depths between `near` and `far` (metres).
    pub fn perspective(
        position: DVec3,
        forward: DVec3,
        (fov_y, aspect): (f64, f64),
        [near, far]: [f64; 2],
    ) -> Self {
        Self {
            position,
            rotation: look_along(forward).unwrap_or_default(),
            projection: Projection {
                field: Field::Perspective { fov_y },
                aspect,
                near,
                far,
            },
            eye: 0.0,
        }
    }

    /// Checks that the view can be drawn.
    ///
    /// # Errors
    /// A position that is not finite, a rotation that is not of unit length, or a fault of the
    /// projection's.
    pub fn validate(&self) -> Result<(), PlanError> {
        PlanError::check(
            self.position.is_finite(),
            "the view's position",
            self.position,
            "finite",
        )?;
        PlanError::check(
            (self.rotation.length() - 1.0).abs() < 1e-5,
            "the view's rotation",
            self.rotation,
            "of unit length",
        )?;
        PlanError::check(self.eye.is_finite(), "the view's eye", self.eye, "finite")?;
        self.projection.validate()
    }

    /// The view of the same picture from `nearest` to `farthest` (view depths, metres): an orthographic view stands
    /// close before `nearest`, wherever its camera stands, so that positions relative to the view and depths are small
    /// numbers, and no depth is below 0. A perspective view is left as it is.
    pub fn around(self, nearest: f64, farthest: f64) -> Self {
        let Field::Orthographic { height } = self.projection.field else {
            return self;
        };
        if !(nearest <= farthest && (farthest - nearest).is_finite()) {
            return self;
        }
        let width = height * self.projection.aspect;
        // A margin in proportion to all lengths in view: larger than the rounding of any position that is seen, and
        // room between the planes even if all that is seen lies in one plane.
        let margin = (farthest - nearest + height + width) / 64.0;
        let step = nearest - margin;
        Self {
            position: self.position + step * (self.rotation.normalize() * DVec3::NEG_Z),
            eye: self.eye - step,
            projection: Projection {
                near: (self.projection.near - step).max(0.5 * margin),
                far: (self.projection.far - step).min(farthest + margin - step),
                ..self.projection
            },
            ..self
        }
    }

    /// The way it looks: unit, world axes.
    pub fn forward(&self) -> DVec3 {
        self.rotation * DVec3::NEG_Z
    }

    /// From camera-relative positions (world axes, metres from `position`) to the view's axes.
    pub fn view_relative(&self) -> DMat4 {
        DMat4::from_quat(self.rotation.normalize().conjugate())
    }

    /// From camera-relative positions (world axes, metres from `position`) to clip space. Cast it to
    /// f32 only when nothing is left to multiply it with.
    pub fn view_proj_relative(&self) -> DMat4 {
        self.projection.matrix() * self.view_relative()
    }

    /// The volume that it sees, in world space.
    pub fn frustum(&self) -> Frustum {
        Frustum::from_matrix(self.view_proj_relative() * DMat4::from_translation(-self.position))
    }

    /// The volume that it sees, in camera-relative space.
    pub fn frustum_relative(&self) -> Frustum {
        Frustum::from_matrix(self.view_proj_relative())
    }

    /// Direction (unit, world axes) of the ray to a camera-relative position.
    pub fn sight(&self, position: DVec3) -> DVec3 {
        match self.projection.field {
            Field::Perspective { .. } => position.normalize_or(self.forward()),
            Field::Orthographic { .. } => self.forward(),
        }
    }

    /// The frustum between two view depths (metres, the first below the second, and above 0 where rays spread), in
    /// camera-relative space.
    pub fn part_relative(&self, near: f64, far: f64) -> Frustum {
        let projection = Projection {
            near,
            far,
            ..self.projection
        };
        Frustum::from_matrix(projection.matrix() * self.view_relative())
    }
}

impl Projection {
    /// Checks that it projects.
    ///
    /// # Errors
    /// An angle outside 0..π, a height, an aspect, `near` or `far` that is not above 0 (above `near`), or
    /// one of these that is not finite.
    pub fn validate(&self) -> Result<(), PlanError> {
        let Self {
            field,
            aspect,
            near,
            far,
        } = *self;
        match field {
            Field::Perspective { fov_y } => PlanError::check(
                fov_y > 0.0 && fov_y < std::f64::consts::PI,
                "the view's vertical angle",
                fov_y,
                "above 0 and below π",
            ),
            Field::Orthographic { height } => PlanError::check(
                height > 0.0 && height.is_finite(),
                "the view's height",
                height,
                "finite and above 0",
            ),
        }?;
        PlanError::check(
            aspect > 0.0 && aspect.is_finite(),
            "the view's aspect",
            aspect,
            "finite and above 0",
        )?;
        PlanError::check(
            near.is_finite(),
            "the view's near distance",
            near,
            "finite and above 0",
        )?;
        PlanError::check(
            far > near && far.is_finite(),
            "the view's far distance",
            far,
            "finite and above the near distance",
        )?;
        PlanError::check(
            near > 0.0,
            "the view's near distance",
            near,
            "finite and above 0",
        )
    }

    /// Whether rays are parallel.
    pub fn is_orthographic(&self) -> bool {
        matches!(self.field, Field::Orthographic { .. })
    }

    /// Width and height of what is seen at a view depth (metres).
    pub fn size_at(&self, depth: f64) -> DVec2 {
        let height = match self.field {
            Field::Perspective { fov_y } => 2.0 * (0.5 * fov_y).tan() * depth,
            Field::Orthographic { height } => height,
        };
        DVec2::new(height * self.aspect, height)
    }

    /// The terms that make depths of clip space linear: x + y · depth is one over the view depth, or the view depth itself (metres)
    /// where rays are parallel.
    pub fn depth_terms(&self) -> [f64; 2] {
        // At depth 0 and at depth 1.
        let [far, near] = match self.field {
            Field::Perspective { .. } => [1.0 / self.far, 1.0 / self.near],
            Field::Orthographic { .. } => [self.far, self.near],
        };
        [far, near - far]
    }

    /// The view depth (metres) of a depth of clip space, 1 at `near` to 0 at `far`.
    pub fn view_depth(&self, depth: f64) -> f64 {
        let [x, y] = self.depth_terms();
        let linear = x + y * depth;
        match self.field {
            Field::Perspective { .. } => 1.0 / linear,
            Field::Orthographic { .. } => linear,
        }
    }

    /// From the view's axes to clip space.
    pub fn matrix(&self) -> DMat4 {
        let Self {
            field,
            aspect,
            near,
            far,
        } = *self;
        let span = far - near;
        match field {
            Field::Perspective { fov_y } => {
                let focal = 1.0 / (0.5 * fov_y).tan();
                DMat4::from_cols(
                    DVec4::new(focal / aspect, 0.0, 0.0, 0.0),
                    DVec4::new(0.0, focal, 0.0, 0.0),
                    DVec4::new(0.0, 0.0, near / span, -1.0),
                    DVec4::new(0.0, 0.0, near * far / span, 0.0),
                )
            }
            Field::Orthographic { height } => DMat4::from_cols(
                DVec4::new(2.0 / (height * aspect), 0.0, 0.0, 0.0),
                DVec4::new(0.0, 2.0 / height, 0.0, 0.0),
                DVec4::new(0.0, 0.0, 1.0 / span, 0.0),
                DVec4::new(0.0, 0.0, far / span, 1.0),
            ),
        }
    }
}

/// The rotation that turns −z to `direction` with +y as far up as can be; none for no direction.
pub fn look_along(direction: DVec3) -> Option<DQuat> {
    let forward = direction.try_normalize()?;
    let up = if forward.y.abs() > 0.999_999 {
        DVec3::NEG_Z
    } else {
        DVec3::Y
    };
    let right = forward.cross(up).try_normalize()?;
    let axes = DMat3::from_cols(right, right.cross(forward), -forward);
    Some(DQuat::from_mat3(&axes))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn view(field: Field, [near, far]: [f64; 2], turn: f64) -> View {
        View {
            position: DVec3::new(4.0, -2.0, 9.0),
            rotation: DQuat::from_euler(glam::EulerRot::YXZ, turn, 0.4 * turn, 0.2),
            projection: Projection {
                field,
                aspect: 1.6,
                near,
                far,
            },
            eye: 0.0,
        }
    }

    /// A depth of clip space leads back to the view depth that it came from.
    #[test]
    fn depths_lead_back() {
        let fields = [
            Field::Perspective { fov_y: 0.9 },
            Field::Orthographic { height: 5.0 },
        ];
        for field in fields {
            let view = view(field, [0.1, 300.0], 0.7);
            for depth in [0.1, 0.5, 20.0, 299.0, 300.0] {
                let point = view.rotation * DVec3::new(0.03, -0.02, -depth);
                let clip = view.view_proj_relative().project_point3(point);
                let found = view.projection.view_depth(clip.z);
                assert!((found / depth - 1.0).abs() < 1e-9, "{found} for {depth}");
            }
        }
    }

    /// Where a point of the world is seen, and how deep.
    fn place(view: &View, point: DVec3) -> DVec3 {
        let clip = view.view_proj_relative();
        clip.project_point3(point - view.position)
    }

    proptest! {
        /// Straight ahead it is the middle, half the height up it is the edge; depth falls evenly from 1 to 0.
        #[test]
        fn an_orthographic_view_sees_a_box(
            height in 1e-3..1e4, near in -50.0..50.0, length in 1e-2..1e4, turn in -3.0..3.0,
            x in -1.0..1.0, y in -1.0..1.0, z in 0.0..1.0,
        ) {
            let view = view(Field::Orthographic { height }, [near, near + length], turn);
            let depth: f64 = near + z * length;
            let seen = DVec3::new(0.8 * height * x, 0.5 * height * y, -depth);
            let at = place(&view, view.position + view.rotation * seen);
            prop_assert!(at.abs_diff_eq(DVec3::new(x, y, 1.0 - z), 1e-6), "{at}");
            prop_assert!(view.sight(seen).abs_diff_eq(view.forward(), 1e-12));
        }

        /// The picture, and which of two is nearer, stay the same wherever the view stands; nothing that is seen lies
        /// behind it, and depths that settings count from the camera stay where they are.
        #[test]
        fn an_orthographic_view_may_stand_anywhere(
            height in 1e-3..1e4, near in -1e6..1e6, length in 1e-2..1e4, turn in -3.0..3.0,
            (from, to) in (0.0..0.5, 0.5..1.0), t in 0.0..1.0, x in -1.0..1.0, y in -1.0..1.0,
        ) {
            let own = view(Field::Orthographic { height }, [near, near + length], turn);
            let [nearest, farthest] = [from, to].map(|share| near + share * length);
            let moved = own.clone().around(nearest, farthest);
            prop_assert_eq!(moved.projection.validate(), Ok(()));
            let span = moved.projection.far - moved.projection.near;
            prop_assert!(span <= length + 1e-12 * (length + near.abs()));
            let depth: f64 = nearest + t * (farthest - nearest);
            let point = own.position
                + own.rotation * DVec3::new(0.8 * height * x, 0.5 * height * y, -depth);
            let (before, after) = (place(&own, point), place(&moved, point));
            prop_assert!(before.truncate().abs_diff_eq(after.truncate(), 1e-5), "{before} {after}");
            prop_assert!((0.0..=1.0).contains(&after.z), "{after}");
            let relative = (point - moved.position).dot(moved.forward());
            prop_assert!(relative > 0.0 && (relative - moved.eye - depth).abs() < 1e-6 * (1.0 + near.abs()));
        }
    }

    /// Far away and narrow, a perspective is an orthographic view.
    #[test]
    fn a_perspective_from_far_away_tends_to_an_orthographic_view() {
        let height = 3.0;
        let orthographic = view(Field::Orthographic { height }, [1.0, 11.0], 0.7);
        let point = orthographic.position + orthographic.rotation * DVec3::new(1.1, -0.8, -4.0);
        let expected = place(&orthographic, point);
        for away in [1e3, 1e5] {
            let fov_y = 2.0 * (0.5 * height / away).atan();
            let mut far = view(Field::Perspective { fov_y }, [1.0 + away, 11.0 + away], 0.7);
            far.position -= away * far.forward();
            let error = place(&far, point).distance(expected);
            assert!(error < 12.0 / away, "{error} from {away} m");
        }
    }

    #[test]
    fn what_does_not_project_is_named() {
        let message = |field, ends| {
            let fault = view(field, ends, 0.0).projection.validate();
            fault
                .map_err(|error| error.to_string())
                .err()
                .unwrap_or_default()
        };
        let flat = Field::Orthographic { height: 0.0 };
        assert_eq!(
            message(flat, [1.0, 2.0]),
            "the view's height is 0, but must be finite and above 0"
        );
        let orthographic = Field::Orthographic { height: 2.0 };
        assert_eq!(
            message(orthographic, [5.0, 2.0]),
            "the view's far distance is 2, but must be finite and above the near distance"
        );
        assert_ne!(message(orthographic, [f64::NAN, 2.0]), "");
        assert_eq!(message(orthographic, [1.0, 2.0]), "");
    }
}

//! The camera.

use glam::{DMat4, DQuat, DVec3, DVec4};

use crate::{Frustum, PlanError};

/// A camera: world space, metres, right-handed, y up; it looks along −z of its own axes.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// Where it stands.
    pub position: DVec3,
    /// From its axes to the world's.
    pub rotation: DQuat,
    /// How it projects.
    pub projection: Projection,
}

/// A perspective projection. Clip space is WebGPU's, depth reversed: 1 at `near`, 0 at `far`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection {
    /// Full vertical angle, radians.
    pub fov_y: f64,
    /// Width over height.
    pub aspect: f64,
    /// Metres, above 0.
    pub near: f64,
    /// Metres, above `near`.
    pub far: f64,
}

impl View {
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
        self.projection.validate()
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

    /// What it sees, in world space.
    pub fn frustum(&self) -> Frustum {
        Frustum::from_matrix(self.view_proj_relative() * DMat4::from_translation(-self.position))
    }

    /// What it sees, in camera-relative space.
    pub fn frustum_relative(&self) -> Frustum {
        Frustum::from_matrix(self.view_proj_relative())
    }

    /// What it sees between two view depths (metres, the first above 0 and below the second), in camera-relative
    /// space.
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
    /// An angle outside 0..π, an aspect, `near` or `far` that is not above 0 (above `near`), or
    /// one of these that is not finite.
    pub fn validate(&self) -> Result<(), PlanError> {
        let Self {
            fov_y,
            aspect,
            near,
            far,
        } = *self;
        PlanError::check(
            fov_y > 0.0 && fov_y < std::f64::consts::PI,
            "the view's vertical angle",
            fov_y,
            "above 0 and below π",
        )?;
        PlanError::check(
            aspect > 0.0 && aspect.is_finite(),
            "the view's aspect",
            aspect,
            "finite and above 0",
        )?;
        PlanError::check(
            near > 0.0 && near.is_finite(),
            "the view's near distance",
            near,
            "finite and above 0",
        )?;
        PlanError::check(
            far > near && far.is_finite(),
            "the view's far distance",
            far,
            "finite and above the near distance",
        )
    }

    /// From the view's axes to clip space.
    pub fn matrix(&self) -> DMat4 {
        let Self {
            fov_y,
            aspect,
            near,
            far,
        } = *self;
        let focal = 1.0 / (0.5 * fov_y).tan();
        let span = far - near;
        DMat4::from_cols(
            DVec4::new(focal / aspect, 0.0, 0.0, 0.0),
            DVec4::new(0.0, focal, 0.0, 0.0),
            DVec4::new(0.0, 0.0, near / span, -1.0),
            DVec4::new(0.0, 0.0, near * far / span, 0.0),
        )
    }
}

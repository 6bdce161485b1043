use glam::DVec3;
use umbrage_shadow::PlanError;

use super::{MOST_PIXELS, MOST_STRATA};

/// Why a scene has no truth to trace: what, where, and what to do.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TruthError {
    /// No object has a triangle.
    #[error("the scene has no triangles; give it a model or a shape")]
    NoTriangles,
    /// More triangles than the tree can number.
    #[error(
        "the scene has {found} triangles, but no more than {most} can be traced; leave some out"
    )]
    TooManyTriangles {
        /// How many there are.
        found: usize,
        /// How many there may be.
        most: usize,
    },
    /// Nothing shines.
    #[error("the scene has no lights; give it one")]
    NoLights,
    /// A light is asked for that is not there.
    #[error("there is no light {index}; the scene has {count}, counted from 0")]
    NoSuchLight {
        /// The number asked for, from 0.
        index: usize,
        /// How many lights there are.
        count: usize,
    },
    /// A triangle has a corner that its mesh lacks.
    #[error("object `{object}` names vertex {vertex}, but its mesh has {count}; mend the model")]
    NoSuchVertex {
        /// The object's name.
        object: String,
        /// The number named, from 0.
        vertex: u32,
        /// How many vertices there are.
        count: usize,
    },
    /// A vertex is nowhere, or too far away.
    #[error(
        "vertex {vertex} of object `{object}` lies {position} m from the camera, but each coordinate must be \
         finite and within 1e15 m; mend the model or its transform"
    )]
    Vertex {
        /// The object's name.
        object: String,
        /// The vertex, from 0.
        vertex: usize,
        /// Metres, world axes, relative to the camera.
        position: DVec3,
    },
    /// A picture without pixels, or with too many.
    #[error(
        "a picture of {width} × {height} pixels cannot be traced; ask for 1 to {MOST_PIXELS} pixels"
    )]
    Size {
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
    },
    /// The camera cannot see.
    #[error("the camera cannot be used: {0}")]
    Camera(PlanError),
    /// A light cannot shine.
    #[error("light {index} cannot be used: {problem}")]
    Light {
        /// The light, from 0.
        index: usize,
        /// Why.
        problem: PlanError,
    },
    /// The extent given to a light is none.
    #[error(
        "a light of size {size} and {strata} × {strata} rays cannot be traced; the size must be finite and above \
         0 (an angle below π/2 for a directional light), and the rays 1 to {MOST_STRATA} each way"
    )]
    Source {
        /// As given.
        size: f64,
        /// As given.
        strata: u32,
    },
    /// A sight of another scene, or of another camera.
    #[error("the sight was not taken with this tracer; look again")]
    ForeignSight,
}

use umbrage_shadow::PlanError;

/// Why no figures can be worked out: what, where, and what to do.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FigureError {
    /// Pictures of different sizes.
    #[error("{what} has {found} pixels, but must have {expected}; take all pictures at one size")]
    Length {
        /// Name of the picture.
        what: String,
        /// Pixels that it has.
        found: usize,
        /// Pixels that it should have.
        expected: usize,
    },
    /// A sight of another scene.
    #[error(
        "the sight names triangle {triangle} of object {object}, which the scene lacks; look at this very scene"
    )]
    ForeignSight {
        /// The object, from 0.
        object: u32,
        /// Its triangle, from 0.
        triangle: u32,
    },
    /// The camera cannot see.
    #[error("the camera cannot be used: {0}")]
    Camera(PlanError),
    /// Frames with different numbers of lights.
    #[error(
        "frame {frame} has the terms of {found} lights, but frame 0 those of {expected}; give every frame all lights"
    )]
    Lights {
        /// The frame, from 0.
        frame: usize,
        /// How many it has.
        found: usize,
        /// How many the first one has.
        expected: usize,
    },
    /// A picture without pixels, or with too many.
    #[error(
        "a picture of {width} × {height} pixels cannot be compared; give it 1 to {most} pixels"
    )]
    Size {
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
        /// How many there may be.
        most: usize,
    },
}

impl FigureError {
    /// Checks that a picture has as many pixels as the sight.
    pub(super) fn check(
        what: impl FnOnce() -> String,
        found: usize,
        expected: usize,
    ) -> Result<(), Self> {
        if found == expected {
            return Ok(());
        }
        let what = what();
        Err(Self::Length {
            what,
            found,
            expected,
        })
    }
}

//! Passes: how a root's entry points are run, and what for.

use serde::Deserialize;

/// How a pass is run, and what for: told by the axis value that names its root, so that no one who runs passes, or tells
/// what they cost, has to know them by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pass {
    /// Things that it is run over.
    pub over: Over,
    /// Use of its results.
    pub purpose: Purpose,
    /// How its colours meet those that are there.
    #[serde(default)]
    pub blend: Blend,
    /// Use of the depth that is there.
    #[serde(default)]
    pub depth: Depth,
}

/// Things that a pass is run over.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
pub enum Over {
    /// Objects that may cast shadows, as a light sees them.
    Casters,
    /// A scene's objects, as the camera sees them.
    Objects,
    /// A picture or a map, by one triangle around it.
    Screen,
    /// Groups of invocations.
    Compute,
}

/// Use of a pass's results.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
pub enum Purpose {
    /// Shadow maps, and what is computed from them: a light's plan asks for it.
    Maps,
    /// Shadow terms of what is seen, or what they are found from.
    Shadow,
    /// One light's share of a picture.
    Light,
    /// A picture's share that no light has.
    Scene,
    /// Figures and tests; no picture has it.
    Measuring,
}

/// How a pass's colours meet those that are there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
pub enum Blend {
    /// They take their place.
    #[default]
    Replace,
    /// They are added to them.
    Add,
    /// They are multiplied by them.
    Multiply,
}

/// Factor of a colour where two meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Factor {
    /// It counts for nothing.
    Zero,
    /// It counts as it is.
    One,
    /// It counts times what is drawn.
    Drawn,
}

impl Blend {
    /// Factors of what is drawn and of what is there, which are then added up, in all channels; none where what is drawn takes
    /// the other's place.
    pub fn factors(self) -> Option<[Factor; 2]> {
        match self {
            Self::Replace => None,
            Self::Add => Some([Factor::One, Factor::One]),
            Self::Multiply => Some([Factor::Zero, Factor::Drawn]),
        }
    }
}

/// A pass's use of the depth that is there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
pub enum Depth {
    /// None.
    #[default]
    Ignored,
    /// New depth is held against it, and leaves it.
    Tested,
    /// New depth is held against it, and takes its place.
    Written,
}

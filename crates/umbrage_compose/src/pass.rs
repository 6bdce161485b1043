//! Passes: how a root's entry points are run, and what for.

use serde::Deserialize;

/// How a pass is run, and what for: told by the axis value that names its root, so that no one who runs passes, or tells
/// what they cost, has to know them by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pass {
    /// What it is run over.
    pub over: Over,
    /// What it is for.
    pub purpose: Purpose,
    /// How its colours meet those that are there.
    #[serde(default)]
    pub blend: Blend,
    /// What it does with the depth that is there.
    #[serde(default)]
    pub depth: Depth,
}

/// What a pass is run over.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
pub enum Over {
    /// What may cast shadows, as a light sees it.
    Casters,
    /// A scene's objects, as the camera sees them.
    Objects,
    /// A picture or a map, by one triangle around it.
    Screen,
    /// Groups of invocations.
    Compute,
}

/// What a pass is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
pub enum Purpose {
    /// Shadow maps, and what is computed from them: a light's plan asks for it.
    Maps,
    /// Shadow terms of what is seen, or what they are found from.
    Shadow,
    /// One light's share of a picture.
    Light,
    /// What a picture shows whatever lights there are.
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

/// What a pass does with the depth that is there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
pub enum Depth {
    /// Nothing.
    #[default]
    Ignored,
    /// It is held against it, and leaves it.
    Tested,
    /// It is held against it, and takes its place.
    Written,
}

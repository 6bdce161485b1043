//! Scenes that catch shadow methods out, and the limits that they are held to. The crate's page lists
//! them.

mod depth;
mod direction;
mod empty;
mod figure;
mod form;
mod judge;
mod limits;
mod motion;
mod orthographic;
mod place;
mod reach;
mod shapes;
mod stage;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod tests_of_limits;
#[cfg(test)]
mod tests_of_scenes;
mod wall;

use std::{collections::BTreeMap, fmt};

use umbrage_render::{Camera, RenderOptions, Scene};
use umbrage_shadow::Choice;

pub use self::{
    figure::DIFFERS,
    judge::{Miss, Verdict},
    limits::{Limit, Limits},
};
use crate::Config;

/// A scene that is hard to shadow.
#[derive(Clone, Debug)]
pub struct Case {
    /// Name in tables and reports: the kind of case, and which of it.
    pub name: &'static str,
    /// Difficulty, in a line.
    pub hard: &'static str,
    /// The scene. No light has a method; the shadows of all are measured.
    pub scene: Scene,
    /// Values of the method's axes that make the case; of a method without the axis, none.
    pub axes: BTreeMap<&'static str, &'static str>,
    /// Values of the method's settings that make the case, or the nearest that the method allows; of a
    /// method without the setting, none.
    pub settings: BTreeMap<&'static str, f64>,
    /// The frames of a motion, in order; empty where the scene's own camera is the only one.
    pub frames: Vec<Camera>,
    /// The case whose shadows this one must show, pixel by pixel.
    pub same_as: Option<&'static str>,
    /// Pixels of the picture, across and down.
    pub size: (u32, u32),
}

impl Case {
    /// The scene's own camera or, of a motion, that of each frame.
    pub fn cameras(&self) -> &[Camera] {
        if self.frames.is_empty() {
            std::slice::from_ref(&self.scene.camera)
        } else {
            &self.frames
        }
    }

    /// How `variant`, whose parts are `choice`, is asked to render this case: as it is, but for what makes the case.
    ///
    /// # Errors
    /// Why it is not, as the two do not go together.
    pub fn options(&self, variant: &Config, choice: &Choice) -> Result<RenderOptions, String> {
        let mut options = variant.options(self.size);
        for (axis, value) in &self.axes {
            if choice.axes().contains(axis) {
                choose(&mut options.shadow.axes, axis, (*value).to_owned())?;
            }
        }
        for (name, value) in &self.settings {
            let settings = choice.settings();
            if let Some(setting) = settings.iter().find(|s| s.name == *name) {
                // As near to what makes the case as the part can come.
                let value = value.clamp(setting.min, setting.max);
                choose(&mut options.shadow.settings, name, value)?;
            }
        }
        Ok(options)
    }

    fn with_axis(mut self, axis: &'static str, value: &'static str) -> Self {
        self.axes.insert(axis, value);
        self
    }

    fn with_setting(mut self, name: &'static str, value: f64) -> Self {
        self.settings.insert(name, value);
        self
    }
}

/// Has a case choose `value`, where the variant has not chosen another.
fn choose<V: PartialEq + fmt::Display>(
    chosen: &mut BTreeMap<String, V>,
    name: &str,
    value: V,
) -> Result<(), String> {
    match chosen.get(name).filter(|other| **other != value) {
        Some(other) => Err(format!(
            "the case has `{name}` at {value}, the variant at {other}"
        )),
        None => {
            chosen.insert(name.to_owned(), value);
            Ok(())
        }
    }
}

/// All hard cases, the same each time. A case stands after the one that it must look the same as.
pub fn all() -> Vec<Case> {
    let families: [fn() -> Vec<Case>; 9] = [
        depth::cases,
        direction::cases,
        place::cases,
        form::cases,
        reach::cases,
        empty::cases,
        motion::cases,
        wall::cases,
        orthographic::cases,
    ];
    families.into_iter().flat_map(|family| family()).collect()
}

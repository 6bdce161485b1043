//! Demands of a scene and the options on its lights, checked.

use std::collections::BTreeMap;

use glam::{DMat4, DVec3, Mat4};
use umbrage_compose::{Key, Library, Purpose};
use umbrage_hints::ending;
use umbrage_shadow::{Constants, Light, LightKind, Registry, Support, look_along};
use umbrage_wgpu::{CheckedShadow, check_value};

use super::{RenderOptions, passes::NamedPass};
use crate::{
    RenderError,
    scene::{Object, Scene, SceneLight},
};

/// A light with its method, both checked.
pub(super) struct LightSetup<'a> {
    pub(super) source: &'a SceneLight,
    /// Its number in the scene.
    pub(super) index: usize,
    pub(super) method: Option<CheckedShadow>,
    /// Whether it goes through a medium.
    pub(super) in_medium: bool,
}

/// Where a shader has a light's shadow term from.
#[derive(Clone, Copy)]
pub(super) enum Term<'a> {
    /// The light's method.
    Method,
    /// The light's method, with these values of its axes in place of the light's.
    Region(&'a BTreeMap<String, String>),
    /// A mask.
    Mask,
    /// The light's method, at points in the air.
    Air,
}

/// Axes that the renderer sets for each draw, so that they cannot be chosen by name.
const OWN_AXES: [&str; 6] = [
    "camera",
    "pass",
    "light",
    "medium",
    "method",
    "vertex_color",
];

/// Choices for shadows in the air, whatever is chosen for surfaces: the shader library allows no other there.
const AIR_AXES: [(&str, &str); 4] = [
    ("pcf", "3"),
    ("receiver_bias", "constant"),
    ("taper", "off"),
    ("transition", "hard"),
];

/// Checks what `scene` and `options` ask of the lights.
pub(super) fn set_up<'a>(
    scene: &'a Scene,
    options: &RenderOptions,
    registry: &Registry,
    library: &Library,
) -> Result<Vec<LightSetup<'a>>, RenderError> {
    for (axis, value) in &options.shadow.axes {
        check_option(library, axis, value)?;
    }
    let mut setups = Vec::new();
    for (index, source) in scene.lights.iter().enumerate() {
        source
            .light
            .validate()
            .map_err(|fault| RenderError::Scene {
                what: format!("light `{}`", source.name),
                source: fault,
            })?;
        let casts = options.shadow.method.is_empty() || scene.casts_shadow(source);
        let method = match casts {
            true => set_up_method(source, options, registry, library)?,
            false => None,
        };
        setups.push(LightSetup {
            source,
            index,
            method,
            in_medium: scene.medium.is_some_and(|air| air.extinction() > 0.0),
        });
    }
    Ok(setups)
}

fn set_up_method(
    source: &SceneLight,
    options: &RenderOptions,
    registry: &Registry,
    library: &Library,
) -> Result<Option<CheckedShadow>, RenderError> {
    let light = source.name.clone();
    let own = source.shadow.as_ref();
    let checked = options.shadow.over(own, registry, library);
    let checked = checked.map_err(|source| RenderError::Shadow {
        light: light.clone(),
        source,
    })?;
    let Some(checked) = checked else {
        return Ok(None);
    };
    if let Support::No(reason) = checked.method().supports(&source.light) {
        return Err(RenderError::Unsupported {
            light,
            method: checked.method().name().to_owned(),
            reason,
        });
    }
    let choices = checked.choices(&source.light);
    let legal = library.key(choices.chain([("pass", TERM)]));
    legal.map_err(|source| RenderError::Excluded { light, source })?;
    Ok(Some(checked))
}

/// The pass for which a shadow's values are checked to go together: the shadow term, and nothing beside it.
const TERM: &str = "shadow_term";

/// Checks what the options choose for an axis.
fn check_option(library: &Library, axis: &str, value: &str) -> Result<(), RenderError> {
    let fault = |problem: String| RenderError::Axis {
        place: "the options".to_owned(),
        axis: axis.to_owned(),
        problem,
    };
    if OWN_AXES.contains(&axis) {
        let problem = "which follows from the scene; choose a method by its own option";
        return Err(fault(problem.to_owned()));
    }
    if library.axes().get(axis).is_none() {
        let known: Vec<&str> = library
            .axes()
            .iter()
            .map(|axis| axis.name.as_str())
            .collect();
        let (hint, known) = (ending(axis, known.iter().copied()), known.join(", "));
        return Err(fault(format!(
            "but there is no axis of that name (known: {known}){hint}"
        )));
    }
    check_value(library, axis, value).map_err(|error| fault(format!("but {error}")))
}

/// The key of a draw in `pass`: of `object`, where objects are drawn; for a light, where the pass is
/// for one, and by where the light's shadow term comes from. With the options comes whether the camera is orthographic.
pub(super) fn key(
    library: &Library,
    (options, orthographic): (&RenderOptions, bool),
    pass: NamedPass<'_>,
    light: Option<(&LightSetup<'_>, Term<'_>)>,
    object: Option<&Object>,
) -> Result<Key, RenderError> {
    let mut choices = BTreeMap::from([("pass", pass.name)]);
    choices.extend(object.into_iter().flat_map(object_axes));
    choices.extend(self::choices(options, orthographic));
    let (light, term) = light.unzip();
    let kind = light.map(|light| light.source.light.kind.name());
    // Other lights have no projection that a cookie could be seen through.
    if kind != Some("spot") {
        choices.remove("cookie");
    }
    if let (Some(light), Some(kind)) = (light, kind) {
        choices.insert("light", kind);
        if light.in_medium && pass.purpose == Purpose::Light {
            choices.insert("medium", "on");
        }
        if kind == "spot" && light.source.cookie.is_some() {
            choices.insert("cookie", "on");
        }
        if let Some(Term::Mask) = term {
            choices.insert("method", "mask");
        } else if let Some(setup) = &light.method {
            choices.insert("method", setup.method().name());
            choices.extend(setup.axes.iter().map(|(a, v)| (a.as_str(), v.as_str())));
        }
        if let Some(Term::Air) = term {
            // A plan's bounds and maps are made for filters as wide as the surfaces', and hold for narrower ones.
            let narrower = choices.get("pcf") == Some(&"1");
            let serves = |(axis, _): &(&str, _)| *axis != "pcf" || !narrower;
            choices.extend(AIR_AXES.into_iter().filter(serves));
        }
        if let Some(Term::Region(axes)) = term {
            choices.extend(axes.iter().map(|(a, v)| (a.as_str(), v.as_str())));
        }
    }
    Ok(library.key(choices)?)
}

/// Choices of an object and its material.
pub(super) fn object_axes(object: &Object) -> [(&str, &str); 4] {
    let switch = |on: bool| if on { "on" } else { "off" };
    let material = &object.material;
    [
        ("surface", material.surface.as_str()),
        ("alpha_test", switch(material.alpha_cutoff.is_some())),
        (
            "base_color_texture",
            switch(material.base_color_texture.is_some()),
        ),
        ("vertex_color", switch(!object.mesh.colors.is_empty())),
    ]
}

/// Choices of the options and the camera, for all objects and passes.
pub(super) fn choices(options: &RenderOptions, orthographic: bool) -> Vec<(&str, &str)> {
    let axes = options.shadow.axes.iter();
    let axes = axes.map(|(axis, value)| (axis.as_str(), value.as_str()));
    let camera = orthographic.then_some(("camera", "orthographic"));
    axes.chain(camera).collect()
}

/// The values of the light's uniform block, relative to a camera at `eye`.
pub(super) fn constants(light: &Light, eye: DVec3) -> Constants {
    let constants = light.constants(eye);
    match light.kind {
        LightKind::Spot {
            position,
            direction,
            outer_angle,
            ..
        } => constants.with(
            "cookie_matrix",
            cookie(position - eye, direction, outer_angle),
        ),
        _ => constants,
    }
}

/// World to the cookie's texture coordinates, before the division by w: the picture fills the square
/// around the cone, and is seen unmirrored from the light, its top up.
fn cookie(position: DVec3, direction: DVec3, outer_angle: f64) -> Mat4 {
    let rotation = look_along(direction).unwrap_or_default();
    let to_light = DMat4::from_rotation_translation(rotation, position).inverse();
    let scale = 0.5 / outer_angle.tan();
    // In light space the axis is −z: u = 0.5 + scale · x / −z, v = 0.5 − scale · y / −z.
    let project = DMat4::from_cols_array_2d(&[
        [scale, 0.0, 0.0, 0.0],
        [0.0, -scale, 0.0, 0.0],
        [-0.5, -0.5, 0.0, -1.0],
        [0.0, 0.0, 0.0, 0.0],
    ]);
    (project * to_light).as_mat4()
}

#[cfg(test)]
mod tests {
    use glam::{Vec2, Vec4};

    use super::*;

    #[test]
    fn a_cookie_hangs_upright_before_its_light() {
        let at = |x: f64, y: f64, z: f64| {
            let position = DVec3::new(1.0, 2.0, 3.0);
            let matrix = cookie(position, DVec3::X, 45_f64.to_radians());
            let point = (position + DVec3::new(x, y, z)).as_vec3();
            let projected = matrix * Vec4::from((point, 1.0));
            Vec2::new(projected.x, projected.y) / projected.w
        };
        assert!(at(5.0, 0.0, 0.0).abs_diff_eq(Vec2::splat(0.5), 1e-5));
        // Looking along +x with y up, +z is to the right.
        assert!(at(5.0, 5.0, 0.0).abs_diff_eq(Vec2::new(0.5, 0.0), 1e-5));
        assert!(at(5.0, 0.0, 5.0).abs_diff_eq(Vec2::new(1.0, 0.5), 1e-5));
    }
}

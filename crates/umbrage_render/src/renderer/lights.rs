//! What a scene and the options ask of its lights, checked.

use std::collections::BTreeMap;

use glam::{DMat4, DVec3, Mat4};
use umbrage_compose::{Key, Library, Purpose};
use umbrage_hints::ending;
use umbrage_shadow::{
    Constants, Light, LightKind, Registry, Settings, ShadowMethod, Support, Value,
};

use super::{RenderOptions, draw::Term, passes::NamedPass};
use crate::{
    RenderError,
    scene::{Object, Scene, SceneLight, Shadow, look_along},
};

/// A light with its method, both checked.
pub(super) struct LightSetup<'a> {
    pub(super) source: &'a SceneLight,
    /// Its number in the scene.
    pub(super) index: usize,
    pub(super) method: Option<MethodSetup<'a>>,
    /// Whether it goes through a medium.
    pub(super) in_medium: bool,
}

/// A light's method and what is chosen for it.
pub(super) struct MethodSetup<'a> {
    pub(super) method: &'a dyn ShadowMethod,
    pub(super) settings: Settings,
    /// A value for each of the method's axes.
    pub(super) axes: BTreeMap<String, String>,
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

/// What shadows in the air are found with, whatever is chosen for surfaces: the shader library allows no other there.
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
    registry: &'a Registry,
    library: &Library,
) -> Result<Vec<LightSetup<'a>>, RenderError> {
    for (axis, value) in &options.axes {
        if OWN_AXES.contains(&axis.as_str()) {
            return Err(RenderError::Axis {
                place: "the options".to_owned(),
                axis: axis.clone(),
                problem: "which follows from the scene; choose a method by its own option"
                    .to_owned(),
            });
        }
        check_value(library, "the options", axis, value)?;
    }
    let none = Shadow::default();
    let mut setups = Vec::new();
    for (index, source) in scene.lights.iter().enumerate() {
        source
            .light
            .validate()
            .map_err(|fault| RenderError::Scene {
                what: format!("light `{}`", source.name),
                source: fault,
            })?;
        let chosen = match (&options.method, &source.shadow) {
            (Some(method), _) if method == Shadow::NONE || !scene.casts_shadow(source) => None,
            // What a scene chooses for one method means nothing to another.
            (Some(method), shadow) => {
                let shadow = shadow.as_ref().filter(|shadow| shadow.method == *method);
                Some((method, shadow.unwrap_or(&none)))
            }
            (None, Some(shadow)) if shadow.method == Shadow::NONE => None,
            (None, Some(shadow)) => Some((&shadow.method, shadow)),
            (None, None) => None,
        };
        let method = match chosen {
            Some((name, shadow)) => Some(set_up_method(
                source, name, shadow, options, registry, library,
            )?),
            None => None,
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

fn set_up_method<'a>(
    source: &SceneLight,
    name: &str,
    shadow: &Shadow,
    options: &RenderOptions,
    registry: &'a Registry,
    library: &Library,
) -> Result<MethodSetup<'a>, RenderError> {
    let light = source.name.clone();
    let method = registry
        .get(name)
        .map_err(|source| RenderError::UnknownMethod {
            light: light.clone(),
            source,
        })?;
    if let Support::No(reason) = method.supports(&source.light) {
        return Err(RenderError::Unsupported {
            light,
            method: name.to_owned(),
            reason,
        });
    }
    let place = format!("light `{light}`");
    if let Some(axis) = shadow
        .axes
        .keys()
        .find(|axis| !method.axes().contains(&axis.as_str()))
    {
        let known = method.axes().join(", ");
        let hint = ending(axis, method.axes().iter().copied());
        let problem =
            format!("but method `{name}` has no axis of that name (known: {known}){hint}");
        return Err(RenderError::Axis {
            place,
            axis: axis.clone(),
            problem,
        });
    }
    let mut axes = BTreeMap::new();
    for &axis in method.axes() {
        let value = options.axes.get(axis).or_else(|| shadow.axes.get(axis));
        let value = match (
            value,
            library.axes().get(axis).and_then(|a| a.default.clone()),
        ) {
            (Some(value), _) => value.clone(),
            (None, Some(default)) => default,
            (None, None) => String::new(),
        };
        check_value(library, &place, axis, &value)?;
        axes.insert(axis.to_owned(), value);
    }
    let chosen = shadow
        .settings
        .iter()
        .chain(&options.settings)
        .map(|(name, value)| (name.as_str(), *value));
    let settings =
        Settings::check(method.settings(), chosen).map_err(|source| RenderError::Settings {
            light,
            method: name.to_owned(),
            source,
        })?;
    Ok(MethodSetup {
        method: method.as_ref(),
        settings,
        axes,
    })
}

fn check_value(library: &Library, place: &str, axis: &str, value: &str) -> Result<(), RenderError> {
    let problem = match library.axes().get(axis) {
        None => {
            let known: Vec<&str> = library
                .axes()
                .iter()
                .map(|axis| axis.name.as_str())
                .collect();
            let hint = ending(axis, known.iter().copied());
            format!(
                "but there is no axis of that name (known: {}){hint}",
                known.join(", ")
            )
        }
        Some(found) if !found.values().any(|known| known == value) => {
            format!(
                "but `{value}` is none of its values: {}",
                found.values().collect::<Vec<_>>().join(", ")
            )
        }
        Some(_) => return Ok(()),
    };
    Err(RenderError::Axis {
        place: place.to_owned(),
        axis: axis.to_owned(),
        problem,
    })
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
    let switch = |on: bool| if on { "on" } else { "off" };
    let mut choices = BTreeMap::from([("pass", pass.name)]);
    if let Some(object) = object {
        let material = &object.material;
        let textured = material.base_color_texture.is_some();
        choices.insert("surface", material.surface.as_str());
        choices.insert("alpha_test", switch(material.alpha_cutoff.is_some()));
        choices.insert("base_color_texture", switch(textured));
        choices.insert("vertex_color", switch(!object.mesh.colors.is_empty()));
    }
    choices.extend(
        options
            .axes
            .iter()
            .map(|(axis, value)| (axis.as_str(), value.as_str())),
    );
    if orthographic {
        choices.insert("camera", "orthographic");
    }
    let (light, term) = light.unzip();
    let kind = light.map(|light| kind_name(&light.source.light.kind));
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
            choices.insert("method", setup.method.name());
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

fn kind_name(kind: &LightKind) -> &'static str {
    match kind {
        LightKind::Directional { .. } => "directional",
        LightKind::Spot { .. } => "spot",
        LightKind::Point { .. } => "point",
    }
}

/// The values of the light's uniform block, relative to a camera at `eye`.
pub(super) fn constants(light: &Light, eye: DVec3) -> Constants {
    let vector = |v: DVec3| Value::Vec3(v.as_vec3());
    let number = |x: f64| Value::F32(x as f32);
    let color = Value::Vec3(light.color);
    match light.kind {
        LightKind::Directional { direction } => Constants::new()
            .with("to_light", vector(-direction))
            .with("irradiance", color),
        LightKind::Spot {
            position,
            direction,
            inner_angle,
            outer_angle,
            range,
        } => Constants::new()
            .with("position_ws", vector(position - eye))
            .with("range", number(range))
            .with("direction", vector(direction))
            .with("cos_outer", number(outer_angle.cos()))
            .with("intensity", color)
            .with("cos_inner", number(inner_angle.cos()))
            .with(
                "cookie_matrix",
                Value::Mat4(cookie(position - eye, direction, outer_angle)),
            ),
        LightKind::Point { position, range } => Constants::new()
            .with("position_ws", vector(position - eye))
            .with("range", number(range))
            .with("intensity", color),
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

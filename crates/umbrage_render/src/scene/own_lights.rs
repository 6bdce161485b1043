//! The lights that a bare model brings: how bright they are in its picture, and how far they reach.
//!
//! glTF gives lux and candela, and a picture has no exposure to turn them into colours by: a sun may come with 3 or
//! with 100 000. So all lights of a model are scaled alike, as a camera would expose it: the brightest hundredth of
//! its surface begins at the irradiance that the sun which is made up for other models would give.

use std::collections::BTreeMap;

use glam::DVec3;
use umbrage_shadow::{Light, LightKind};

use super::{Object, SceneLight, Shadow, model::Lamp};

/// Irradiance of a model's brightest part; an irradiance of π makes a white surface white.
pub(super) const BRIGHT: f32 = 3.0;
/// Share of a model's surface that is its brightest part.
const BRIGHTEST: f64 = 0.01;
/// Range of a light without an end, as a multiple of the farthest corner's distance: there the window takes 1/256
/// of its light.
const ENDLESS: f64 = 4.0;
/// Bits of an irradiance's mantissa (of 52) by which parts that share an entry may differ.
const DROPPED: u32 = 40;

/// The lights of a scene of `objects` that `lamps` are, each with the shadow of the sun that is made up for other
/// models.
pub(super) fn own_lights(mut lamps: Vec<Lamp>, objects: &[Object]) -> Vec<SceneLight> {
    for lamp in &mut lamps {
        end(&mut lamp.kind, objects);
    }
    let exposure = exposure(&lamps, objects);
    let lights = lamps.into_iter().map(|lamp| SceneLight {
        name: lamp.name,
        light: Light {
            kind: lamp.kind,
            color: lamp.color * exposure,
        },
        cookie: None,
        shadow: Some(Shadow {
            method: "basic".to_owned(),
            ..Shadow::default()
        }),
    });
    lights.collect()
}

/// Gives a light an end that has none.
fn end(kind: &mut LightKind, objects: &[Object]) {
    let (LightKind::Point { position, range }
    | LightKind::Spot {
        position, range, ..
    }) = kind
    else {
        return;
    };
    if range.is_infinite() {
        let corners = objects
            .iter()
            .flat_map(|object| [object.bounds.min, object.bounds.max]);
        let away = corners.map(|corner| (corner - *position).abs());
        *range = ENDLESS * away.fold(DVec3::ZERO, DVec3::max).length();
    }
}

/// Factor by which all lights are multiplied.
fn exposure(lamps: &[Lamp], objects: &[Object]) -> f32 {
    // Parts of about the same irradiance share an entry, which keeps the most of it and their area: a model may
    // show a mesh of a million triangles a thousand times.
    let mut parts: BTreeMap<u64, (f64, f64)> = BTreeMap::new();
    for object in objects {
        for corners in object.mesh.indices.as_chunks::<3>().0 {
            let [a, b, c] = corners.map(|corner| {
                let position = object.mesh.positions.get(corner as usize).copied();
                object
                    .transform
                    .transform_point3(position.unwrap_or_default().as_dvec3())
            });
            let area = 0.5 * (b - a).cross(c - a).length();
            let middle = (a + b + c) / 3.0;
            let light: f64 = lamps.iter().map(|lamp| irradiance(lamp, middle)).sum();
            // Bits of floats from zero up are in the floats' order.
            let (most, total) = parts.entry(light.to_bits() >> DROPPED).or_default();
            *most = most.max(light);
            *total += area;
        }
    }
    let mut left = BRIGHTEST * parts.values().map(|(_, area)| area).sum::<f64>();
    let brightest = parts.values().rev().find(|(_, area)| {
        left -= *area;
        left < 0.0
    });
    // Where less than that share is lit, the brightest triangle counts.
    let mut candidates = brightest.into_iter().chain(parts.values().last());
    let light = candidates.find(|(light, _)| *light > 0.0);
    // A lamp that is too dim for floats is as bright as floats can make it.
    light.map_or(1.0, |(light, _)| {
        (f64::from(BRIGHT) / light).min(f64::from(f32::MAX).sqrt()) as f32
    })
}

/// Irradiance that a lamp gives to a surface at `point` that faces it, in its brightest channel.
fn irradiance(lamp: &Lamp, point: DVec3) -> f64 {
    let bright = f64::from(lamp.color.max_element());
    let from = |position: DVec3, range: f64| {
        let distance = position.distance(point);
        let window = 1.0 - (distance / range).powi(4);
        bright * window.max(0.0) / distance.powi(2).max(1e-20)
    };
    match lamp.kind {
        LightKind::Directional { .. } => bright,
        LightKind::Point { position, range } => from(position, range),
        LightKind::Spot {
            position,
            direction,
            outer_angle,
            range,
            ..
        } => {
            let way = (point - position).normalize_or_zero();
            let inside = way.dot(direction) > outer_angle.cos();
            if inside { from(position, range) } else { 0.0 }
        }
    }
}

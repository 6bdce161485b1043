//! Opacity of a surface: whether a point of it is there.

use glam::DVec2;
use umbrage_render::{Level, Material, Texture, Wrap};

/// Whether the material has a surface where the mesh has these texture coordinates and this opacity.
pub(super) fn is_solid(material: &Material, at: impl FnOnce() -> (DVec2, f64)) -> bool {
    let Some(cutoff) = material.alpha_cutoff else {
        return true;
    };
    let (uv, opacity) = at();
    let texture = material.base_color_texture.as_ref();
    let texel = texture.map_or(1.0, |texture| sample(texture, uv));
    f64::from(material.base_color.w) * texel * opacity >= f64::from(cutoff)
}

/// The texture's opacity in full resolution; 1 of a texture without texels.
fn sample(texture: &Texture, uv: DVec2) -> f64 {
    let Some(level) = texture.image.levels.first() else {
        return 1.0;
    };
    let place = uv * DVec2::new(f64::from(level.width), f64::from(level.height));
    if !texture.smooth {
        return texel(level, texture.wrap, place.floor());
    }
    let first = (place - 0.5).floor();
    let part = place - 0.5 - first;
    let row = |down: f64| {
        let at = |across: f64| texel(level, texture.wrap, first + DVec2::new(across, down));
        at(0.0) * (1.0 - part.x) + at(1.0) * part.x
    };
    row(0.0) * (1.0 - part.y) + row(1.0) * part.y
}

fn texel(level: &Level, [across, down]: [Wrap; 2], place: DVec2) -> f64 {
    let column = wrapped(across, place.x, level.width);
    let row = wrapped(down, place.y, level.height);
    let texel = level
        .rgba
        .get(row as usize * level.width as usize + column as usize);
    texel.map_or(1.0, |rgba| f64::from(rgba[3]) / 255.0)
}

/// The texel that stands at `place` (a whole number) of an endless row.
fn wrapped(wrap: Wrap, place: f64, size: u32) -> u32 {
    let count = f64::from(size);
    let inside = match wrap {
        Wrap::Clamp => place,
        Wrap::Repeat => place.rem_euclid(count),
        Wrap::Mirror => {
            let place = place.rem_euclid(2.0 * count);
            place.min(2.0 * count - 1.0 - place)
        }
    };
    inside.clamp(0.0, (count - 1.0).max(0.0)) as u32
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use umbrage_render::Image;

    use super::*;

    #[test]
    fn rows_are_endless() {
        let row = |wrap| {
            (-3..6)
                .map(|place| wrapped(wrap, f64::from(place), 3))
                .collect::<Vec<_>>()
        };
        assert_eq!(row(Wrap::Repeat), [0, 1, 2, 0, 1, 2, 0, 1, 2]);
        assert_eq!(row(Wrap::Clamp), [0, 0, 0, 0, 1, 2, 2, 2, 2]);
        assert_eq!(row(Wrap::Mirror), [2, 1, 0, 0, 1, 2, 2, 1, 0]);
    }

    #[test]
    fn opacity_is_the_factor_times_the_texel() {
        let level = Level {
            width: 2,
            height: 1,
            rgba: vec![[255, 255, 255, 255], [255, 255, 255, 51]],
        };
        let mut texture = Texture {
            image: Arc::new(Image {
                levels: vec![level],
            }),
            wrap: [Wrap::Repeat; 2],
            smooth: false,
        };
        let at = |texture: &Texture, u| sample(texture, DVec2::new(u, 0.5));
        assert_eq!([at(&texture, 0.49), at(&texture, 0.51)], [1.0, 0.2]);
        texture.smooth = true;
        assert!((at(&texture, 0.5) - 0.6).abs() < 1e-12);
        assert!((at(&texture, 1.0) - 0.6).abs() < 1e-12, "it repeats");

        let mut material = Material {
            alpha_cutoff: Some(0.5),
            base_color_texture: Some(texture),
            ..Material::plain("lambert")
        };
        let solid = |material: &Material, u| is_solid(material, || (DVec2::new(u, 0.5), 1.0));
        assert!(solid(&material, 0.25) && !solid(&material, 0.75));
        assert!(!is_solid(&material, || (DVec2::new(0.25, 0.5), 0.49)));
        material.base_color.w = 0.4;
        assert!(!solid(&material, 0.25));
        material.alpha_cutoff = None;
        assert!(solid(&material, 0.75));
    }
}

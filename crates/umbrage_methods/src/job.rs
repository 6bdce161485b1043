//! What methods with depth maps do before they fit them: checks, and a frame relative to the camera.

use glam::{DVec2, DVec3};
use umbrage_shadow::{Aabb, Beam, Extent, Frame, Frustum, Lens, PlanError, Rect, Setting};

/// The nearest near plane of a spot or point light, as a share of its range. Reversed depth keeps its
/// relative precision over this ratio, and more.
pub(crate) const NEAREST: f64 = 1e-5;

/// How much farther than needed the near and far planes stand, relative: beyond any rounding.
pub(crate) const PADDING: f64 = 1.0 / 8192.0;

/// A frame's boxes, camera-relative.
pub(crate) struct Boxes {
    /// The camera's position in the world.
    pub origin: DVec3,
    /// What the camera sees.
    pub camera: Frustum,
    /// As the frame has them.
    pub casters: Vec<Aabb>,
    /// Those that the light may reach.
    pub receivers: Vec<Aabb>,
}

impl Boxes {
    /// Those of `frame`.
    pub(crate) fn new(frame: &Frame<'_>) -> Self {
        let origin = frame.view.position;
        let lit = frame
            .casters
            .receivers
            .iter()
            .filter(|r| frame.light.reaches(r));
        Self {
            origin,
            camera: frame.view.frustum_relative(),
            casters: frame
                .casters
                .casters
                .iter()
                .map(|c| c.translate(-origin))
                .collect(),
            receivers: lit.map(|r| r.translate(-origin)).collect(),
        }
    }
}

/// Checks the frame, and that each of `settings` has a value in its range.
pub(crate) fn check(frame: &Frame<'_>, settings: &[Setting]) -> Result<(), PlanError> {
    frame.validate()?;
    for setting in settings {
        let value = frame.settings.get(setting.name);
        let what = format!("the setting `{}`", setting.name);
        let holds = (setting.min..=setting.max).contains(&value);
        let expected = format!("{} to {}", setting.min, setting.max);
        PlanError::check(holds, &what, value, &expected)?;
    }
    Ok(())
}

/// The value of an axis, "missing" where it has none.
pub(crate) fn axis<'a>(frame: &Frame<'a>, name: &str) -> &'a str {
    frame.axes.get(name).map_or("missing", String::as_str)
}

/// What the value of an axis stands for, among `known`.
pub(crate) fn choice<T: Copy>(
    frame: &Frame<'_>,
    name: &str,
    known: &[(&str, T)],
) -> Result<T, PlanError> {
    let value = axis(frame, name);
    let found = known.iter().find(|(known, _)| *known == value);
    found.map(|(_, found)| *found).ok_or_else(|| {
        let names: Vec<_> = known.iter().map(|(name, _)| *name).collect();
        PlanError::Invalid {
            what: format!("the axis `{name}`"),
            value: value.to_owned(),
            expected: names.join(", "),
        }
    })
}

/// The filter's width in texels: the axis `pcf`.
pub(crate) fn filter_width(frame: &Frame<'_>) -> Result<u32, PlanError> {
    let pcf = axis(frame, "pcf");
    let width = pcf.parse().unwrap_or(0);
    PlanError::check(
        width % 2 == 1 && width <= 15,
        "the axis `pcf`",
        pcf,
        "odd, 1 to 15",
    )?;
    Ok(width)
}

/// How far from its middle a filter `width` texels wide reads, texels: half its width, a texel's fetch,
/// and room for rounding.
pub(crate) fn margin(width: u32) -> f64 {
    0.5 * f64::from(width) + 1.5
}

/// What keeps a map's receivers from shading themselves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bias {
    /// A receiver's depth is raised by x + y · depth: so many `texels` towards the light.
    pub raise: DVec2,
    /// A texel's width as depth is x + y · depth.
    pub texel: DVec2,
    /// In texels' widths: the setting `depth_bias`, and what rounding may be.
    pub texels: f64,
    /// What of it is for rounding.
    pub rounding: f64,
}

impl Bias {
    /// That of a directional light's map whose texels are `texel` metres wide: `bias` texels.
    pub(crate) fn directional(seen: &Extent, bias: f64, texel: f64) -> Self {
        let range = seen.far - seen.near;
        let far = seen.near.abs().max(seen.far.abs());
        let rounding = 4.0 * seen.precision.max(Extent::PRECISION * far);
        let shift = bias * texel + rounding;
        Self {
            raise: DVec2::new(shift / range, 0.0),
            texel: DVec2::new(texel / range, 0.0),
            texels: shift / texel,
            rounding: rounding / texel,
        }
    }

    /// That of a spot light's map. At distance d from the light a texel is `texel` · d wide, so that a shift by
    /// `bias` texels is one by a share s = `bias` · `texel` of d; rounding adds to s, and is worst for the receiver
    /// `nearest` to the light. One over the distance grows by this share, s / (1 − s), and so does depth − A, as
    /// depth is A + B / d, and falls by B / d² a metre.
    pub(crate) fn perspective(
        lens: &Lens,
        seen: &Extent,
        bias: f64,
        texel: f64,
        nearest: f64,
    ) -> Self {
        // Beyond the whole distance a shift has no meaning.
        let most = 0.9;
        let rounding = Extent::PRECISION + seen.precision / nearest.max(1e-3 * seen.far);
        let rounding = (4.0 * rounding).min(most);
        let share = (bias * texel + rounding).min(most);
        let risen = DVec2::new(-lens.depth_terms(seen.near, seen.far).x, 1.0);
        Self {
            raise: share / (1.0 - share) * risen,
            texel: texel * risen,
            texels: share / texel,
            rounding: rounding / texel,
        }
    }
}

/// Where a directional light's `casters` lie in the lens's plane: their shadows lie nowhere else.
pub(crate) fn shaded(lens: &Lens, casters: &[Aabb]) -> Option<Rect> {
    let corners = casters.iter().flat_map(Aabb::corners);
    Rect::from_points(corners.map(|corner| lens.place(corner).0))
}

/// The near plane of a directional light's map, and the casters that it needs: those between the light and
/// what is `seen`. Moves the planes apart by more than rounding.
pub(crate) fn directional_casters(lens: &Lens, seen: &mut Extent, casters: &[Aabb]) -> Vec<usize> {
    let corners = casters.iter().flat_map(Aabb::corners);
    let nearest = corners.map(|p| lens.place(p).1).fold(seen.near, f64::min);
    let padding = PADDING * (seen.far - nearest) + 4.0 * seen.precision;
    seen.far += padding;
    let beam = Beam::new(lens, &seen.rect, nearest - padding, seen.far, casters);
    seen.near = seen.near.min(beam.near);
    seen.near -= PADDING * (seen.far - seen.near) + 4.0 * seen.precision;
    beam.casters
}

/// The same for a spot light, of which nothing is nearer than `floor` (metres).
pub(crate) fn spot_casters(
    lens: &Lens,
    seen: &mut Extent,
    floor: f64,
    casters: &[Aabb],
) -> Vec<usize> {
    seen.far *= 1.0 + PADDING;
    let beam = Beam::new(lens, &seen.rect, floor, seen.far, casters);
    seen.near = (seen.near.min(beam.near) * (1.0 - PADDING)).max(floor);
    beam.casters
}

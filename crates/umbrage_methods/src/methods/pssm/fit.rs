//! The splits, and what each one's map holds.

use glam::{DMat4, DVec2, DVec3};
use umbrage_shadow::{
    Aabb, Bias, Bounds, Extent, Field, Frame, Frustum, Lens, MapRange, Placed, PlanError,
    Projection, Rect, Side, View, Volume, split_depths,
};

use super::{Lookup, SETTINGS, range::Range};

/// A frame's numbers, checked.
pub(super) struct Job<'a> {
    pub frame: &'a Frame<'a>,
    pub bounds: Bounds,
    view: View,
    splits: usize,
    lambda: f64,
    pub shadow_distance: Option<f64>,
    /// Texels along a tile's side.
    pub tile: u32,
    depth_bias: f64,
    band: f64,
    pub follows_plane: bool,
    pub lookup: Lookup,
    pub transition: Transition,
    stable: bool,
    /// Bounds of the depths that are split.
    pub range: Range,
}

/// How one split passes into the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Transition {
    Hard,
    Blend,
    Dither,
}

/// The splits that receivers touch, and what they share.
pub(super) struct Splits {
    /// World (camera-relative) to base space.
    pub base: DMat4,
    /// Ascending.
    pub splits: Vec<Split>,
}

impl Splits {
    /// Whether a split passes into another: the last one, and one before a gap, passes into nothing.
    pub(super) fn has_next(&self, split: &Split) -> bool {
        let mut all = self.splits.iter();
        all.any(|next| next.depths[0] == split.depths[1])
    }
}

/// One split's map.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Split {
    /// The view depths at which it begins and ends, metres.
    pub depths: [f64; 2],
    /// Depths that its map holds: they begin in the band of the split before.
    pub held: [f64; 2],
    /// From base space to texels of the map (y down) and depth: base · scale + offset · w.
    pub scale: DVec3,
    pub offset: DVec3,
    /// A receiver's depth d is biased towards the light by x + y · d.
    pub receiver_bias: DVec2,
    pub bias: Bias,
    /// World (camera-relative) to clip space.
    pub view_proj: DMat4,
    pub casters: Vec<usize>,
    /// The distances that the map holds.
    pub range: MapRange,
}

impl<'a> Job<'a> {
    pub(super) fn new(frame: &'a Frame<'a>) -> Result<Self, PlanError> {
        frame.validate()?;
        for setting in &SETTINGS {
            frame.setting(setting)?;
        }
        let setting = |name| frame.settings.get(name);
        let distance = setting("shadow_distance");
        let tile = setting("resolution") as u32;
        let fits = [("stable", true), ("tight", false)];
        let transitions = [
            ("hard", Transition::Hard),
            ("blend", Transition::Blend),
            ("dither", Transition::Dither),
        ];
        frame.choice("taper", &[("off", ()), ("on", ())])?;
        Ok(Self {
            frame,
            bounds: frame.bounds(),
            view: frame.view.clone(),
            splits: setting("splits") as usize,
            lambda: match frame.view.projection.field {
                Field::Perspective { .. } => setting("lambda"),
                // Pixels are as large at all depths.
                Field::Orthographic { .. } => 0.0,
            },
            shadow_distance: (distance > 0.0).then_some(frame.view.eye + distance),
            tile,
            depth_bias: frame.depth_bias(setting("depth_bias"), tile)?,
            band: setting("band"),
            lookup: Lookup::of(frame, setting("splits") as usize)?,
            follows_plane: frame
                .choice("receiver_bias", &[("constant", false), ("plane", true)])?,
            transition: frame.choice("transition", &transitions)?,
            stable: frame.choice("fit", &fits)?,
            range: Range::of(frame)?,
        })
    }

    /// How much of a split before its end passes into the next one, metres.
    pub(super) fn band_length(&self, split: &Split) -> f64 {
        self.band * (split.depths[1] - split.depths[0])
    }

    /// The way that the camera looks.
    pub(super) fn forward(&self) -> DVec3 {
        self.view.forward()
    }

    pub(super) fn directional(&self, direction: DVec3) -> Result<Splits, PlanError> {
        let lens = Lens::directional(direction);
        let all = Placed::new(&lens, &self.bounds.casters);
        let Some(shaded) = all.bound().map(|bound| Rect::of(&bound)) else {
            return Ok(Splits {
                base: lens.base(),
                splits: Vec::new(),
            });
        };
        let slices = self.slices(&lens, DVec3::ZERO, None, Some(&shaded))?;
        let fit = |slice: Slice| {
            let mut seen = slice.seen;
            seen.rect = if self.stable {
                self.around_sphere(&lens, &slice, &shaded)
            } else {
                self.around(&seen.rect, seen.precision(), slice.inner)
            };
            let casters = seen.take_casters(0.0, &all);
            let texel = self.texel(&seen.rect);
            let bias = Bias::new(&lens, &seen, self.depth_bias, texel, 0.0);
            self.split(&lens, &slice, &seen, casters, bias)
        };
        Ok(Splits {
            base: lens.base(),
            splits: slices.into_iter().map(fit).collect::<Result<_, _>>()?,
        })
    }

    pub(super) fn spot(
        &self,
        position: DVec3,
        direction: DVec3,
        angle: f64,
        range: f64,
    ) -> Result<Splits, PlanError> {
        let lens = Lens::spot(position, direction);
        let floor = Extent::NEAREST * range;
        let cone = Frustum::from_matrix(lens.matrix(&Rect::square(angle.tan()), floor, range));
        let all = Placed::new(&lens, &self.bounds.casters);
        let slices = self.slices(&lens, position, Some(&cone), None)?;
        let fit = |slice: Slice| {
            let mut seen = slice.seen;
            let least = seen.precision() / seen.far;
            seen.rect = if self.stable {
                self.on_grid(&seen.rect, least, slice.inner)
            } else {
                self.around(&seen.rect, least, slice.inner)
            };
            let nearest = seen.near;
            let casters = seen.take_casters(floor, &all);
            let texel = self.texel(&seen.rect);
            let bias = Bias::new(&lens, &seen, self.depth_bias, texel, nearest);
            self.split(&lens, &slice, &seen, casters, bias)
        };
        Ok(Splits {
            base: lens.base(),
            splits: slices.into_iter().map(fit).collect::<Result<_, _>>()?,
        })
    }

    /// The splits that receivers touch. `cone` is what the light reaches, `shaded` the part of the lens's plane where
    /// there is shadow, where these are less than all.
    fn slices(
        &self,
        lens: &Lens,
        position: DVec3,
        cone: Option<&Frustum>,
        shaded: Option<&Rect>,
    ) -> Result<Vec<Slice>, PlanError> {
        let receivers = self.in_view(cone);
        let Some([near, far]) = self.range(&receivers) else {
            return Ok(Vec::new());
        };
        let mut depths = split_depths(near, far, self.splits, self.lambda)?;
        // The first split has the air before all surfaces as well.
        if self.bounds.air && !self.view.projection.is_orthographic() {
            depths[0] = depths[0].min(self.beginning(receivers.depths[0]));
        }
        let seen_in = |[near, far]: [f64; 2]| {
            let [near, far] = [
                near * (1.0 - Extent::PADDING),
                far * (1.0 + Extent::PADDING),
            ];
            let part = self.view.part_relative(near, far);
            let volumes: Vec<_> = std::iter::once(&part).chain(cone).collect();
            let there = receivers.boxes.iter();
            let there =
                there.filter(|(_, [nearest, farthest])| *nearest <= far && near <= *farthest);
            let seen = Extent::of(lens, position, there.map(|(aabb, _)| *aabb), &volumes)?;
            let rect = shaded.map_or(Some(seen.rect), |shaded| shaded.intersection(&seen.rect))?;
            Some(Extent { rect, ..seen })
        };
        let mut slices = Vec::<Slice>::new();
        for pair in depths.windows(2) {
            let depths = [pair[0], pair[1]];
            let mut held = depths;
            if let Some(before) = slices.last().filter(|slice| slice.depths[1] == depths[0])
                && self.transition != Transition::Hard
            {
                held[0] -= self.band * (before.depths[1] - before.depths[0]);
            }
            // A receiver seen in the band alone has the map of the split before.
            let own = seen_in(depths);
            let seen = own.and_then(|own| {
                if held == depths {
                    Some(own)
                } else {
                    seen_in(held)
                }
            });
            if let Some(seen) = seen {
                let margin = self.frame.margin(slices.len())?;
                let inner = f64::from(self.tile) - 2.0 * margin;
                slices.push(Slice {
                    depths,
                    held,
                    seen,
                    inner,
                });
            }
        }
        Ok(slices)
    }

    /// The receivers in the camera's volume and in the `cone`.
    fn in_view(&self, cone: Option<&Frustum>) -> InView<'_> {
        let volumes: Vec<_> = std::iter::once(&self.bounds.camera).chain(cone).collect();
        let mut volume = Volume::new(&volumes);
        let forward = self.view.forward();
        let mut found = InView {
            boxes: Vec::with_capacity(self.bounds.receivers.len()),
            depths: [f64::INFINITY, f64::NEG_INFINITY],
            surface: f64::INFINITY,
        };
        let surfaces = self.bounds.receivers.len() - usize::from(self.bounds.air);
        for (i, receiver) in self.bounds.receivers.iter().enumerate() {
            let side = volume.side(receiver);
            if side == Side::Outside {
                continue;
            }
            let depths = receiver.along(forward);
            found.boxes.push((receiver, depths));
            if side == Side::Inside {
                found.add(depths);
            } else if !found.holds(depths) {
                for point in volume.cut(receiver) {
                    found.add([point.dot(forward); 2]);
                }
            }
            if i < surfaces {
                found.surface = found.depths[0];
            }
        }
        found
    }

    /// The view depths between which receivers are seen, and shadowed. Air that a perspective view sees before all surfaces is
    /// none of it: pixels there are as many as behind, but hardly any light is scattered on so short a way, and splits that
    /// began at the near plane would be too coarse for the surfaces.
    fn range(&self, receivers: &InView<'_>) -> Option<[f64; 2]> {
        let [nearest, far] = receivers.depths;
        let near = match self.view.projection.field {
            Field::Perspective { .. } if receivers.surface.is_finite() => receivers.surface,
            _ => nearest,
        };
        let [near, far] = match self.range {
            Range::Seen([least, most]) => [near.max(least), far.min(most)],
            Range::Boxes | Range::Unknown => [near, far],
        };
        // Nothing is seen.
        if near > far {
            return None;
        }
        let [near, far] = match self.view.projection.field {
            // Its length must not depend on where the view stands: a texel's width follows it.
            Field::Orthographic { height } if self.stable => {
                let length = (far - near).max(height / 64.0);
                steady(near, length, self.view.eye)
            }
            _ => {
                let far = if self.stable {
                    rounded_up(far, RANGE_STEPS)
                } else {
                    far
                };
                let most = self.view.projection.far;
                [
                    self.beginning(near),
                    far.min(most) * (1.0 + Extent::PADDING),
                ]
            }
        };
        let far = self
            .shadow_distance
            .map_or(far, |distance| far.min(distance));
        (near < far - Extent::PADDING * far.abs()).then_some([near, far])
    }

    /// Where splits begin of what is seen from `near` on.
    fn beginning(&self, near: f64) -> f64 {
        let near = if self.stable && !self.view.projection.is_orthographic() {
            rounded_down(near, RANGE_STEPS)
        } else {
            near
        };
        near.max(self.view.projection.near) * (1.0 - Extent::PADDING)
    }

    /// A rectangle widened by its filter's margin, and until its texels are no finer than `least`.
    fn around(&self, rect: &Rect, least: f64, inner: f64) -> Rect {
        let tile = f64::from(self.tile);
        let size = rect.size().max(DVec2::splat(least * tile));
        rect.resized(size * tile / inner)
    }

    /// The square on the world's grid of texels around all that the camera may see in a split as far away as what it does
    /// see there, wherever it looks; or around all that is `shaded`, where that is less.
    fn around_sphere(&self, lens: &Lens, slice: &Slice, shaded: &Rect) -> Rect {
        let reach = rounded_up(slice.seen.reach, SIZE_STEPS);
        let (middle, radius) = sphere(&self.view.projection, slice.held, reach);
        // Relative to the camera is where the number's digits are spent; the grid is the world's.
        let (anchor, _) = lens.place(self.bounds.origin);
        let (center, _) = lens.place(middle * self.view.forward());
        let whole = rounded_up(shaded.size().max_element(), SIZE_STEPS);
        let (center, size) = if whole < 2.0 * radius {
            (0.5 * (shaded.min + shaded.max), whole)
        } else {
            (center, 2.0 * radius)
        };
        self.snapped(
            anchor,
            center,
            stable_texel(size, slice.seen.precision(), slice.inner),
        )
    }

    /// The square on the light's grid of texels around `rect`, its size rounded up.
    fn on_grid(&self, rect: &Rect, least: f64, inner: f64) -> Rect {
        let size = rounded_up(rect.size().max_element(), 2.0);
        let texel = stable_texel(size, least, inner);
        self.snapped(DVec2::ZERO, 0.5 * (rect.min + rect.max), texel)
    }

    /// The map about `center` whose corner is a whole number of texels from the grid's origin, which is at
    /// −`anchor`.
    fn snapped(&self, anchor: DVec2, center: DVec2, texel: f64) -> Rect {
        let tile = f64::from(self.tile);
        let corner = (anchor + center) / texel - 0.5 * tile;
        let min = (corner + 0.5).floor() * texel - anchor;
        Rect {
            min,
            max: min + tile * texel,
        }
    }

    /// A texel's width in the lens's plane.
    fn texel(&self, rect: &Rect) -> f64 {
        rect.size().max_element() / f64::from(self.tile)
    }

    fn split(
        &self,
        lens: &Lens,
        slice: &Slice,
        seen: &Extent,
        casters: Vec<usize>,
        bias: Bias,
    ) -> Result<Split, PlanError> {
        let Rect { min, max } = seen.rect;
        let across = f64::from(self.tile) / seen.rect.size();
        let terms = lens.depth_terms(seen.near, seen.far);
        let rising = if lens.is_perspective() { 1.0 } else { -1.0 };
        Ok(Split {
            depths: slice.depths,
            held: slice.held,
            // Rows of texels count downwards.
            scale: DVec3::new(across.x, -across.y, rising * terms.y),
            offset: DVec3::new(-min.x * across.x, max.y * across.y, terms.x),
            receiver_bias: self.frame.receiver_bias(&bias)?,
            bias,
            view_proj: lens.matrix(&seen.rect, seen.near, seen.far),
            casters,
            range: MapRange::new(lens, seen, self.tile),
        })
    }
}

/// The receivers that may be seen.
struct InView<'a> {
    /// Each one's bounds, and its least and greatest view depth, metres.
    boxes: Vec<(&'a Aabb, [f64; 2])>,
    /// The least and the greatest view depth of what is seen of them: the first is greater where nothing is.
    depths: [f64; 2],
    /// The least of surfaces; infinite where none is seen.
    surface: f64,
}

impl InView<'_> {
    fn holds(&self, [near, far]: [f64; 2]) -> bool {
        self.depths[0] <= near && far <= self.depths[1]
    }

    fn add(&mut self, [near, far]: [f64; 2]) {
        self.depths = [self.depths[0].min(near), self.depths[1].max(far)];
    }
}

/// A split that receivers touch.
struct Slice {
    /// Where it begins and ends.
    depths: [f64; 2],
    /// Depths that its map holds: they begin in the band of the split before.
    held: [f64; 2],
    seen: Extent,
    /// Texels along its map's side without the filter's margins.
    inner: f64,
}

/// Steps to the octave by which sizes are rounded, so that they seldom change, and a texel's width with them.
const SIZE_STEPS: f64 = 8.0;

/// Steps to the octave by which a range's ends are rounded: all splits change with it.
const RANGE_STEPS: f64 = 4.0;

/// A size rounded up to one of `steps` to the octave: what changes little leaves it alone, and so does rounding, which
/// may be a 10,000th of a texel.
fn rounded_up(size: f64, steps: f64) -> f64 {
    const ROUNDING: f64 = 1e-8;
    let octaves = size.max(f64::MIN_POSITIVE).log2() - ROUNDING;
    ((steps * octaves).ceil() / steps).exp2()
}

/// A size rounded down to one of `steps` to the octave.
fn rounded_down(size: f64, steps: f64) -> f64 {
    rounded_up(size.recip(), steps).recip()
}

/// The texel of a map that holds `size` in `inner` texels, one of them to snap to; no finer than `least` rounded up to
/// a power of two.
fn stable_texel(size: f64, least: f64, inner: f64) -> f64 {
    (size / (inner - 1.0)).max(least.log2().ceil().exp2())
}

/// The depth range of an orthographic view from `near` on, rounded outwards so that it seldom changes: its length to
/// two steps an octave, its ends to multiples of an eighth of that length from where the camera stands.
fn steady(near: f64, length: f64, eye: f64) -> [f64; 2] {
    let length = rounded_up(length * 8.0 / 7.0, 2.0);
    let step = length / 8.0;
    let near = ((near - eye) / step).floor() * step + eye;
    [
        near - Extent::PADDING * length,
        near + (1.0 + Extent::PADDING) * length,
    ]
}

/// The smallest sphere around what is seen from view depth `near` to `far` (metres), no farther than `reach` from a camera
/// with a perspective: the depth of its middle on the camera's axis, and its radius.
fn sphere(projection: &Projection, [near, far]: [f64; 2], reach: f64) -> (f64, f64) {
    // Square of half the diagonal at a depth.
    let across = |depth: f64| 0.25 * projection.size_at(depth).length_squared();
    let far = match projection.field {
        // Where the view's edges are that far away. Beyond, all is nearer to a middle before it.
        Field::Perspective { .. } => far.min(reach / (1.0 + across(1.0)).sqrt()),
        // Its camera may stand anywhere.
        Field::Orthographic { .. } => far,
    };
    if far <= near {
        return (near, (reach * reach - near * near).max(0.0).sqrt());
    }
    // Both ends' rims are equally far from the middle, unless it is beyond `far`.
    let apart = 0.5 * (across(far) - across(near)) / (far - near);
    let middle = (0.5 * (near + far) + apart).min(far);
    let to = |depth: f64| (middle - depth).powi(2) + across(depth);
    (middle, to(near).max(to(far)).sqrt())
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// A point seen in the split, and no farther than its reach, lies in the ball, and the ball is no larger than that of
        /// all that may be seen there.
        #[test]
        fn a_sphere_holds_what_is_seen(
            fov_y in 0.1..2.8, aspect in 0.3..3.0, near in 0.1..10.0, ratio in 1.01..9.0, reach in 1.0..4.0,
            at in prop::collection::vec([-1.0..1.0, -1.0..1.0, 0.0..1.0], 64),
        ) {
            let far = near * ratio;
            let projection = Projection { field: Field::Perspective { fov_y }, aspect, near, far };
            let reach = near * reach;
            let (middle, radius) = sphere(&projection, [near, far], reach);
            let (_, whole) = sphere(&projection, [near, far], f64::INFINITY);
            prop_assert!(radius <= whole * (1.0 + 1e-12), "{radius} {whole}");
            for [x, y, z] in at {
                let depth = near + z * (far - near);
                let across = 0.5 * projection.size_at(depth) * DVec2::new(x, y);
                let point = across.extend(depth);
                if point.length() <= reach {
                    let apart = point.distance(DVec3::Z * middle);
                    prop_assert!(apart <= radius * (1.0 + 1e-12), "{apart} {radius}");
                }
            }
        }
    }
}

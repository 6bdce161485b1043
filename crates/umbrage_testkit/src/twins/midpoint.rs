//! The rule of midpoint shadow maps on the CPU.

/// Distance between a followed plane and its own map, in texels' widths: room for rounding.
const LEAST: f64 = 1.0 / 16.0;

/// The slope that a middle holds off where no plane is followed: the tangent of 87°.
const STEEPEST: f64 = 19.0;

/// How far behind the first surface is enough for all else, texels' widths.
const MOST: f64 = 1.5;

/// The depth that a midpoint map holds, in the terms of its settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MidpointTwin {
    /// The setting `depth_bias`, texels.
    pub depth_bias: f64,
    /// The filter's width, texels.
    pub width: u32,
    /// Whether `receiver_bias` is `plane`.
    pub receiver_plane: bool,
}

impl MidpointTwin {
    /// The depth (reversed, 0..1) that a texel holds where the nearest face turned to the light is at the depth `front`
    /// and the nearest back-facing one at `back`, 0 for none. `texel` is a texel's width, as depth, about a depth.
    /// Rounding is left out.
    pub fn depth(self, front: f64, back: f64, texel: impl Fn(f64) -> f64) -> f64 {
        let (least, most) = match self.receiver_plane {
            true => (LEAST, MOST),
            false => (
                self.depth_bias,
                STEEPEST * (0.5 * f64::from(self.width) + 0.5),
            ),
        };
        let most = most.max(self.depth_bias);
        let first = front.max(back);
        let width = texel(first);
        let room = 0.5 * (front - back);
        let behind = if back > 0.0 && room >= least * width {
            room.min(most * width)
        } else {
            self.depth_bias * width
        };
        (first - behind).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Texels of 1 cm over 10 m: a thousandth of the depth each.
    const TEXEL: f64 = 0.001;

    fn twin(receiver_plane: bool) -> MidpointTwin {
        MidpointTwin {
            depth_bias: 1.5,
            width: 3,
            receiver_plane,
        }
    }

    /// How many texels behind the nearer of a front and a back the map holds it.
    fn behind(twin: MidpointTwin, front: f64, back: f64) -> f64 {
        (front.max(back) - twin.depth(front, back, |_| TEXEL)) / TEXEL
    }

    fn assert_behind(twin: MidpointTwin, [front, back]: [f64; 2], expected: f64) {
        let found = behind(twin, front, back);
        assert!((found - expected).abs() < 1e-9, "{found} texels");
    }

    #[test]
    fn the_middle_of_a_body_is_held_but_no_deeper_than_is_of_use() {
        // 1 texel, then 2 and 100: as deep as the default bias.
        assert_behind(twin(true), [0.8, 0.799], 0.5);
        assert_behind(twin(true), [0.8, 0.798], 1.0);
        assert_behind(twin(true), [0.8, 0.7], 1.5);
        // Without the receiver's plane, half of 100, and 19 times the reach of 2.
        assert_behind(twin(false), [0.8, 0.75], 25.0);
        assert_behind(twin(false), [0.8, 0.1], 38.0);
        // A larger bias is for bodies as well.
        let biased = MidpointTwin {
            depth_bias: 4.0,
            ..twin(true)
        };
        assert_behind(biased, [0.8, 0.7], 4.0);
        // Without any, a body keeps its middle, and an open mesh has none.
        let unbiased = MidpointTwin {
            depth_bias: 0.0,
            ..twin(true)
        };
        assert_behind(unbiased, [0.8, 0.7], 1.5);
        assert_behind(unbiased, [0.8, 0.0], 0.0);
    }

    #[test]
    fn what_has_no_inside_is_biased() {
        for twin in [twin(true), twin(false)] {
            // No back; no front; the back before the front; both at once, and nearly so.
            for sides in [
                [0.8, 0.0],
                [0.0, 0.8],
                [0.7, 0.8],
                [0.8, 0.8],
                [0.8, 0.79999],
            ] {
                assert_behind(twin, sides, 1.5);
            }
        }
        // Thinner than the bias: a middle only where the plane is followed.
        assert_behind(twin(false), [0.8, 0.7975], 1.5);
        assert_behind(twin(true), [0.8, 0.7975], 1.25);
    }

    #[test]
    fn nothing_is_held_where_nothing_is_and_nothing_beyond_the_far_end() {
        assert_eq!(twin(true).depth(0.0, 0.0, |_| TEXEL), 0.0);
        assert_eq!(twin(true).depth(0.001, 0.0, |_| TEXEL), 0.0);
    }

    /// Depth is A + B / d: the middle is the harmonic mean, between both and nearer to the front.
    #[test]
    fn under_a_spot_light_the_middle_lies_between() {
        let (near, far) = (0.1, 20.0);
        let depth = |d: f64| (near / d * far - near) / (far - near);
        let distance = |depth: f64| near * far / (depth * (far - near) + near);
        for (front, back) in [(0.2, 0.21), (1.0, 1.5), (2.0, 19.0)] {
            let unbiased = MidpointTwin {
                depth_bias: 0.0,
                ..twin(false)
            };
            let middle = distance(unbiased.depth(depth(front), depth(back), |_| 1.0));
            let harmonic = 2.0 * front * back / (front + back);
            assert!((middle - harmonic).abs() < 1e-9, "{middle}");
            assert!(front < middle && middle < 0.5 * (front + back));
        }
    }

    /// A plate under a table: the farthest surface in the place of the second would light it.
    #[test]
    fn the_farthest_surface_is_not_the_second() {
        let [top, underside, plate, floor] = [0.9, 0.89, 0.7, 0.1];
        let held = |back| twin(false).depth(top, back, |_| 0.01);
        assert!(held(underside) > plate, "in shadow");
        assert!(held(floor) < plate, "lit: what (depth, −depth) would find");
    }
}

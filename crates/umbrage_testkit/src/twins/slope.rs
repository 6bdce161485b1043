//! How a receiver's plane is followed in a map: `common/slope.wesl` on the CPU.

use glam::DVec2;

/// The slope up to which a plane is followed whole, in texels' widths a texel: the shader's constant.
pub(crate) const STEEPEST: f64 = 64.0;

/// Texels by which a rasteriser's grid displaces a plane, and more: the shader's constant.
pub(crate) const ASTRAY: f64 = 1.0 / 256.0;

/// A receiver's plane as it is sampled in a map: the shader's struct.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Followed {
    /// Change of the plane's depth per texel, as far as it is followed.
    pub slope: DVec2,
    /// Step from the receiver's own place to where the map is read, in the filter's reaches.
    pub aside: DVec2,
}

impl Followed {
    /// A plane whose depth changes by `across` / `toward` a texel, where `steepest` is the most that is followed; not
    /// at all where it is unknown or back-facing.
    pub(crate) fn new(across: DVec2, steepest: f64, toward: f64) -> Self {
        let most = steepest * toward;
        if most.is_nan() || most <= 0.0 {
            return Self::default();
        }
        let steep = across.length().max(most);
        let way = across / steep;
        let left = (1.0 - most / steep) * way.abs().element_sum();
        Self {
            slope: steepest * way,
            aside: -left * way,
        }
    }
}

/// How far from its middle a filter `width` texels wide reads, texels.
pub(crate) fn reach(width: u32) -> f64 {
    0.5 * f64::from(width) + 0.5 + ASTRAY
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// However steep a plane is, no texel of it that a tap reads is nearer to the light than the depth that the tap
        /// compares, and the map is read no farther aside than the module says.
        #[test]
        fn no_plane_shades_itself(
            turn in 0.0..6.3, octaves in -3.0..30.0, width in prop::sample::select(vec![1u32, 3, 5, 7, 15]),
            tap in [-1.0..=1.0, -1.0..=1.0], texel in [-1.0..=1.0, -1.0..=1.0],
        ) {
            let slope = f64::exp2(octaves) * DVec2::from_angle(turn);
            let Followed { slope: followed, aside } = Followed::new(slope, STEEPEST, 1.0);
            let step = reach(width) * aside;
            let tap = 0.5 * (f64::from(width) - 1.0) * DVec2::from(tap);
            let compared = followed.dot(tap) + (1.0 + ASTRAY) * followed.abs().element_sum();
            let held = slope.dot(step + tap + DVec2::from(texel));
            prop_assert!(held <= compared + 1e-12 * slope.length(), "{held} {compared}");
            prop_assert!(step.length() <= 2f64.sqrt() * reach(width));
            prop_assert!(followed.length() <= STEEPEST * (1.0 + 1e-12));
            if slope.length() <= STEEPEST {
                prop_assert!(followed.abs_diff_eq(slope, 1e-9) && aside == DVec2::ZERO);
            }
        }
    }

    #[test]
    fn unknown_and_back_facing_planes_are_not_followed() {
        for toward in [0.0, -1.0, f64::NAN] {
            assert_eq!(
                Followed::new(DVec2::X, STEEPEST, toward),
                Followed::default()
            );
        }
        // On edge to the light it is not, as far as numbers tell.
        let edge = Followed::new(DVec2::X, STEEPEST, f64::MIN_POSITIVE);
        assert_eq!((edge.slope, edge.aside), (STEEPEST * DVec2::X, -DVec2::X));
    }
}

//! How often a filter is spared, and what that saves.

use image::RgbImage;
use umbrage_render::{Decision, Picture, RenderError, RenderOptions, Scene, What};

use super::{
    Config, Lab,
    lab::{Subject, mean},
};
use crate::report::Decided;

impl Lab {
    /// How `config`, which takes so many `fetches` a compared pixel, finds the terms of `subject`: in shares, and in the
    /// colours of [`Decision::color`]. None where it always filters, or nothing that is compared samples a map.
    pub(super) fn decided(
        &mut self,
        subject: &Subject<'_>,
        config: &Config,
        fetches: f64,
    ) -> Result<Option<(Decided, RgbImage)>, RenderError> {
        if !self.spares_filter(subject.scene, config)? {
            return Ok(None);
        }
        let options = RenderOptions {
            what: What::Decisions,
            ..config.options(subject.size())
        };
        let rendered = self.render(subject.scene, &options)?;
        let Picture::Decisions(decisions) = &rendered.picture else {
            return Ok(None);
        };
        let Some(shares) = shares(subject.compared(decisions)) else {
            return Ok(None);
        };
        let plain = match self.always_filtering(subject.scene, config) {
            Some(plain) => {
                let counted = self.fetches(subject, &plain.options(subject.size()))?;
                Some(mean(&counted))
            }
            None => None,
        };
        let decided = Decided {
            fetches_saved: plain.map(|plain| plain - fetches),
            ..shares
        };
        Ok(Some((decided, rendered.to_image().into_rgb8())))
    }

    /// Whether the shaders of `config` can find the term of some light of `scene` without filtering. Nothing is drawn.
    pub(super) fn spares_filter(
        &self,
        scene: &Scene,
        config: &Config,
    ) -> Result<bool, umbrage_compose::Error> {
        for light in &scene.lights {
            let key = self.key("decision", &light.light.kind, config)?;
            let permutation = self.compose(&key)?;
            if Decision::spares_filter(&permutation) {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// `config` without the choice of its own that lets it spare the filter; none where it has no such choice.
    fn always_filtering(&self, scene: &Scene, config: &Config) -> Option<Config> {
        let mut without = config.shadow.axes.keys().map(|axis| {
            let mut plain = config.clone();
            plain.shadow.axes.remove(axis);
            // Settings of the part that is gone went with it.
            if let Ok(choice) = plain.shadow.choice(self.registry(), self.library()) {
                let known = choice.settings();
                let is_known = |name: &String| known.iter().any(|setting| setting.name == name);
                plain.shadow.settings.retain(|name, _| is_known(name));
            }
            plain
        });
        // The choices left need not go together.
        without.find(|plain| matches!(self.spares_filter(scene, plain), Ok(false)))
    }
}

/// Share of each decision among the `decisions` of receivers that sample a map; none where none does.
fn shares(decisions: impl Iterator<Item = Decision>) -> Option<Decided> {
    let mut counts = [0_u64; Decision::ALL.len()];
    for decision in decisions {
        let place = Decision::ALL.iter().position(|known| *known == decision);
        if let Some(count) = place.and_then(|place| counts.get_mut(place)) {
            *count += 1;
        }
    }
    let [
        _,
        filtered,
        lit_by_depth,
        lit_by_plane,
        shadowed_by_depth,
        shadowed_by_plane,
    ] = counts;
    let sampled: u64 = counts.iter().skip(1).sum();
    let share = |count: u64| count as f64 / sampled as f64;
    (sampled > 0).then(|| Decided {
        lit_by_depth: share(lit_by_depth),
        lit_by_plane: share(lit_by_plane),
        shadowed_by_depth: share(shadowed_by_depth),
        shadowed_by_plane: share(shadowed_by_plane),
        filtered: share(filtered),
        fetches_saved: None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_of_what_asks() {
        let of = |decisions: &[Decision]| shares(decisions.iter().copied());
        assert_eq!(of(&[Decision::Unsampled; 3]), None);
        let mut decisions = vec![Decision::Unsampled; 90];
        for (decision, count) in [
            (Decision::Filtered, 1),
            (Decision::LitByDepth, 2),
            (Decision::LitByPlane, 3),
            (Decision::ShadowedByDepth, 4),
            (Decision::ShadowedByPlane, 6),
        ] {
            decisions.extend(vec![decision; count]);
        }
        let found = of(&decisions).expect("some ask");
        let expected = Decided {
            filtered: 0.0625,
            lit_by_depth: 0.125,
            lit_by_plane: 0.1875,
            shadowed_by_depth: 0.25,
            shadowed_by_plane: 0.375,
            fetches_saved: None,
        };
        assert_eq!(found, expected);
        let sums = [found.by_plane(), found.by_depth(), found.at_once()];
        assert_eq!(sums, [0.5625, 0.375, 0.9375]);
    }
}

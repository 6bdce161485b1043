//! The nearest depths, compared by the hardware. Its shader half is `depths/nearest.wesl`.
//!
//! Receivers are biased by what the method says, as their own surface lies in the map.

use umbrage_shadow::{DepthSource, Frame, Maps, Part, PlanError, SamplerDesc, ShadowPlan};

/// The depth source `nearest`.
#[derive(Clone, Copy, Debug, Default)]
pub struct Nearest;

impl Part for Nearest {
    fn name(&self) -> &str {
        "nearest"
    }
}

impl DepthSource for Nearest {
    fn fill(&self, _: &Frame<'_>, maps: &Maps, plan: &mut ShadowPlan) -> Result<(), PlanError> {
        maps.nearest(Maps::BINDING, plan);
        plan.samplers.push(SamplerDesc::comparison(maps.order));
        Ok(())
    }
}

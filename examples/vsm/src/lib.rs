//! Variance shadow maps (Donnelly and Lauritzen 2006) as a filter from outside: over `basic`, and over `pssm` with a map
//! for each split (PSVSM), neither of which knows of it. Its shaders lie in `shaders/`.
//!
//! The filtered map holds the mean and the mean square of distances, blurred along rows and columns before any receiver is
//! known. A pixel takes one fetch, and Chebyshev's bound on how much of what was blurred lies behind the receiver: exact
//! where one flat caster hides one flat receiver, and too light where the distances about it vary more (light bleeding).

use umbrage::{
    compose::{Error, Package},
    glam::UVec2,
    methods::filters::Width,
    shadow::{
        Constants, Filter, Frame, MAX_SPLITS, Maps, Need, Part, Pass, PlanError, SamplerDesc,
        ScreenPass, Setting, ShadowPlan, Value,
    },
    wgpu_types::{Features, FilterMode, TextureFormat},
};

/// The filter `vsm`.
pub struct Vsm;

const BLEEDING: Setting = Setting {
    name: "light_bleeding",
    doc: "the share of the light that counts as none: more takes bleeding away, and hardens edges",
    min: 0.0,
    max: 0.95,
    default: 0.3,
    whole: false,
};

const DEVIATION: Setting = Setting {
    name: "least_deviation",
    doc: "the least standard deviation of the distances about a receiver, in texels of the map",
    min: 0.0,
    max: 64.0,
    default: 0.5,
    whole: false,
};

impl Part for Vsm {
    fn name(&self) -> &str {
        "vsm"
    }
    fn settings(&self) -> &[Setting] {
        &[BLEEDING, DEVIATION]
    }
    fn axes(&self) -> &[&str] {
        &[Width::AXIS]
    }
}

impl Filter for Vsm {
    fn reach(&self, frame: &Frame<'_>, number: usize) -> Result<f64, PlanError> {
        Ok(Width::of(frame)?.reach(number))
    }

    fn fetches(&self, _: &Frame<'_>, _: usize) -> Result<u32, PlanError> {
        Ok(1)
    }

    fn prepare(
        &self,
        frame: &Frame<'_>,
        maps: &Maps,
        plan: &mut ShadowPlan,
    ) -> Result<(), PlanError> {
        let (width, deviation) = (Width::of(frame)?, frame.setting(&DEVIATION)?);
        let moments = |name| maps.texture(name, TextureFormat::Rg32Float);
        plan.textures.push(moments("vsm_map"));
        if !maps.maps.is_empty() {
            plan.textures.push(moments("vsm_rows"));
        }
        for (number, map) in maps.maps.iter().enumerate() {
            let blur = Constants::new()
                .with("corner", UVec2::new(map.tile.x, map.tile.y).as_vec2())
                .with("side", map.tile.width)
                .with("width", width.in_map(number))
                .with("ratio", map.range.ratio() as f32);
            for (shader, target) in [("vsm_across", "vsm_rows"), ("vsm_down", "vsm_map")] {
                let pass = ScreenPass::new(shader, target, map.tile, blur.clone());
                plan.passes.push(Pass::Screen(pass));
            }
        }
        let tile = |number: usize| -> Value {
            let (texel, ratio) = maps.maps.get(number).map_or((0.0, 0.0), |map| {
                let length = map.range.far - map.range.near;
                (map.range.texel / length, map.range.ratio())
            });
            let least = (deviation * texel).powi(2).max(1e-7);
            let tile = Constants::new().with("ratio", ratio as f32);
            tile.with("least", least as f32).into()
        };
        let tiles: Vec<_> = (0..MAX_SPLITS).map(tile).collect();
        let bleeding = frame.setting(&BLEEDING)? as f32;
        let constants = Constants::new().with("vsm_tiles", tiles);
        plan.constants
            .extend(constants.with("vsm_bleeding", bleeding));
        plan.samplers
            .push(SamplerDesc::new("vsm_sampler", FilterMode::Linear));
        plan.needs.push(Need {
            features: Features::FLOAT32_FILTERABLE,
            instead: "the filter `pcf`".to_owned(),
        });
        Ok(())
    }
}

/// The package of its shaders.
///
/// # Errors
/// Never, as long as `shaders/` is sound; a test says so.
pub fn package() -> Result<Package, Error> {
    let files = [
        ("axes.ron", include_str!("../shaders/axes.ron")),
        ("blur.wesl", include_str!("../shaders/blur.wesl")),
        ("vsm.wesl", include_str!("../shaders/vsm.wesl")),
    ];
    let files = files.map(|(path, text)| (path.to_owned(), text.to_owned()));
    Package::from_sources("vsm", "examples/vsm/shaders", files)
}

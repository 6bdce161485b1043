//! Exponential shadow maps (Annen et al. 2008, Salvi 2008), values of the axis `filter`: a wide filter for the price
//! of one fetch a pixel. The shader halves are `filters/esm.wesl` and the passes of the folder beside it.
//!
//! # How it works
//! Percentage-closer filtering is a mean of steps: of each texel's distance o from the light, whether it is at least
//! the receiver's r. Where no texel is farther than the receiver, exp(k (o − r)) with a large k is nearly that step,
//! and the mean of products is a product: E[exp(k o)] / exp(k r). Its numerator does not depend on the receiver
//! and can be filtered before that is known.
//!
//! Two compute passes for all maps do that: `esm_across` turns a depth map, whatever it holds, into distances o from 0
//! at the near end of the map's range to 1 at the far one, linear in metres for perspectives too, and takes the mean
//! of exp(k (o − ½)) over W texels of a row; `esm_down` over W rows. Both stay within a tile. One bilinear fetch blends
//! four such means: W + 1 columns and rows of texels weighted 1 − f, 1, …, 1, f, the very kernel of percentage-closer
//! filtering of width W (see `common/pcf.wesl`). The shader takes min(E, e) / e of that mean E and the receiver's own
//! e = exp(k (r − ½)): the term exceeds 1 where the map is behind the receiver, and a quotient of such numbers would
//! overflow.
//!
//! # Values and settings
//! | filter | holds | k at the most | fetches | bytes a texel, beside the depth map's 4 |
//! | --- | --- | ---: | ---: | ---: |
//! | `esm` | exponentials, `r32float` | 163 | 1 | 8 |
//! | `esm_half` | exponentials, `r16float` | 19 | 1 | 10 |
//! | `esm_log` | distances, `r32float`: m + ln(Σ w exp(k (o − m))) / k, m the largest | 65536 | 4 | 8 |
//!
//! 4 of these bytes are a row's means, which a width of 1 does without. With `esm` the hardware filters floats of 32
//! bits, which WebGPU's baseline does not ask of it (`float32-filterable`); the other two need nothing beyond the
//! baseline. A compute shader cannot write half floats there: those of `esm_half` are computed in full ones, 4 bytes, and
//! rounded by a full-screen pass for each map, `esm_round`. It saves time in a pixel's fetch.
//!
//! The largest k keeps exp(±k/2) between a format's least normal and its largest number: ln 65504 = 11.09 and −ln
//! 2⁻¹⁴ = 9.70 in half floats, 88.72 and 87.34 in full ones, where the sum of 15 numbers, each of them twice (see below), must fit (ln 30 = 3.40) and
//! the product with a bilinear weight of 1/256 be normal (ln 256 = 5.55). Logarithms know no such limit, but depths
//! have 24 bits: k · 2⁻²³ is what rounding may make of a term.
//!
//! `exponent` is k, of a map's whole range of distances. 0, the default, chooses for each map the k at which an
//! occluder 2 (W + 1) texels in front of a receiver leaves a hundredth of the light (ln 100 = 4.6): a contact leak of
//! two widths of the filter. It is no more than the format holds, and no less than to darken half of the range. With
//! a perspective those are texels at the range's far end. A larger k shortens the leak, and makes more of slopes.
//!
//! `depth_bias` and `receiver_bias` do nothing. They keep texels of a receiver from shading it, and of an exponential
//! map none does that is a plane: the mean of its texels' distances is its own, and the exponential of a mean is at
//! most the mean of exponentials (Jensen's inequality). A bias of b texels would multiply terms by
//! exp(4.6 b / (2 W + 2)), and a shadow's edge is lit where its share of a window is. Only what rounding may be is
//! added to a receiver's depth; and `depth_bias` after all in maps narrower than 2 W + 6 texels, where a receiver's window is
//! cut off by the map's edge and its mean is not its own.
//!
//! An empty texel counts as twice the range's far end: what lies there is farther than that, and the far edge of a ground
//! would else darken itself, as half of its windows is cut off.
//!
//! By how much the mean is more is what a slope adds: the term on a plane whose distance grows by s_x and s_y of the
//! range a texel is multiplied by sinh(x) / x, x = k s W / 2, for each. With the default k and W = 15 that is 1.2
//! where depth rises by a texel's width a texel (45°), and 3.9 at three times that (72°): on steep receivers shadows
//! become narrower, on each side by up to half of the filter. They are never darker than they should be. To divide by
//! that factor would shade what is steep and ends, such as a wall at its foot.
//!
//! # Cost
//! One fetch a pixel, or four. It is for wide filters: percentage-closer filtering takes 64 fetches at W = 15, and 4 at
//! W = 3.
//!
//! The passes take of each map the cells alone that receivers in view read ([`Frame::cells`]); with air, which reads between the
//! surfaces, all of them. An invocation finds the means about R = min(8, W + 1) texels beside
//! each other (2 with `taper`, where maps differ in width) from the R + W − 1 texels of their windows: at W = 15, each
//! pass 2.75 loads and `esm_across` 2.75 exponentials a texel, where each window by itself would take 15. Windows grow by
//! sums alone; running sums, which subtract what is left behind, would lose small exponentials beside large ones.
//! `esm_log` adds pairs of a largest distance and a sum relative to it, for one exponential each.
//!
//! On Mesa's llvmpipe, a CPU, the two take 0.17 of the time of full-screen passes with W loads a texel at W = 15 (`esm_log`
//! 0.15, `esm_half` and its rounding 0.22), and 0.4 at W = 3; one pass for both, by way of workgroup memory, took 0.3.
//! At W = 15 and 1280 × 720 pixels, shadows add 0.08 of what they add by comparisons to the time of shading, and all passes
//! together take 0.38, those of 2048² texels among them (`esm_half` 0.44, `esm_log` 0.47): `cargo bench --profile dev
//! -p umbrage_bench --bench methods` prints such ratios as `esm over pcf`. With a fifth of these pixels it pays no more.
//!
//! # Limits
//! - *The contact leak*: in full shadow, the term is exp(−k g) for an occluder g of the range in front of its
//!   receiver. It stays above 1 % until g = 4.6 / k: of a range of 100 m that is 2.8 m with `esm` and its largest k,
//!   24 m with `esm_half`. Use the latter for ranges of few metres, and `esm_log` where ranges are long.
//! - *What is behind the receiver*: a texel farther than the receiver by g counts exp(k g) times. Where a window
//!   reaches past a receiver's edge to what lies behind, the receiver is lit, whatever shades it.
//! - *Two occluders above each other*: the map holds the upper one. Where a window holds texels of both, the term is
//!   the lower one's leak by its share: a bright rim, exp(−k g) of its own gap, at the upper one's edge, inside of
//!   what should be one shadow. Foliage leaks so.
//! - Point lights have a cube, and `branches`, `channels` and `weights` their own ways to compare; choose `pcf` for
//!   them.
//! - The range ends at the nearest caster and the farthest receiver. A caster far in front stretches it, and with it
//!   the leak in metres of an exponent that is at its limit.
//!
//! # Sources
//! Annen, Mertens, Seidel, Flerackers, Kautz, "Exponential shadow maps", Graphics Interface 2008. Salvi, "Rendering
//! filtered shadows with exponential shadow maps", ShaderX6, 2008. Filtering of logarithms: Lauritzen and McCool,
//! "Layered variance shadow maps", Graphics Interface 2008, and ShaderX6.

use umbrage_shadow::{
    BufferContents, BufferDesc, Cell, ComputePass, Constants, Filter, Frame, Map, Maps, Need, Part,
    Pass, PlanError, Reads, SamplerDesc, ScreenPass, Setting, ShadowPlan, Value,
};
use wgpu_types::{Features, FilterMode, TextureFormat};

use super::Width;

/// The filtered map, which is read.
const FILTERED: &str = "esm_map";

/// The map filtered along its rows alone.
const ROWS: &str = "esm_rows";

/// The filtered map, before it is rounded to half floats.
const MEANS: &str = "esm_means";

/// The list of cells that are filtered.
const CELLS: &str = "esm_cells";

/// Invocations along a workgroup's sides.
const GROUP: u32 = 8;

/// As many maps as the shader has numbers for.
const MOST_MAPS: usize = umbrage_shadow::MAX_SPLITS;

/// −ln of the share of the light that counts as none.
const DARK: f64 = 4.605_170_185_988_092;

/// How far below an occluder that is by default, in widths of the filter.
const WIDTHS: f64 = 2.0;

/// The exponent k.
const EXPONENT: Setting = Setting {
    name: "exponent",
    doc: "of exponential filters, over the whole range of a map's distances; 0: dark 2 (W + 1) texels below a caster, as nearly as the format holds",
    min: 0.0,
    max: MOST_BY_DEPTH,
    default: 0.0,
    whole: false,
};

/// Where depths of 24 bits make terms of 7: the limit of logarithms.
const MOST_BY_DEPTH: f64 = 65536.0;

/// The filters `esm`, `esm_half` and `esm_log`: what the filtered map holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Esm {
    /// Exponentials, as floats of 32 bits.
    Full,
    /// Exponentials, as floats of 16 bits.
    Half,
    /// Logarithms of the exponentials' means.
    Log,
}

impl Part for Esm {
    fn name(&self) -> &str {
        match self {
            Self::Full => "esm",
            Self::Half => "esm_half",
            Self::Log => "esm_log",
        }
    }

    fn settings(&self) -> &[Setting] {
        &[EXPONENT]
    }

    fn axes(&self) -> &[&str] {
        &[Width::AXIS]
    }
}

impl Filter for Esm {
    fn reach(&self, frame: &Frame<'_>, number: usize) -> Result<f64, PlanError> {
        Ok(Width::of(frame)?.reach(number))
    }

    fn fetches(&self, _: &Frame<'_>, _: usize) -> Result<u32, PlanError> {
        Ok(match self {
            Self::Full | Self::Half => 1,
            Self::Log => 4,
        })
    }

    /// No bias, but where the window may be cut off by the edge of a small map.
    fn depth_bias(&self, frame: &Frame<'_>, texels: f64, side: u32) -> Result<f64, PlanError> {
        let is_small = 4.0 * frame.margin(0)? > f64::from(side);
        Ok(if is_small { texels } else { 0.0 })
    }

    fn prepare(
        &self,
        frame: &Frame<'_>,
        maps: &Maps,
        plan: &mut ShadowPlan,
    ) -> Result<(), PlanError> {
        maps.check_reversed(self.name())?;
        let job = Job {
            esm: *self,
            exponent: self.exponent(frame)?,
            width: Width::of(frame)?,
        };
        let cell = job.cell(maps.side());
        let cells = frame.cells(maps, cell)?;
        job.add(plan, maps, &cells);
        Ok(())
    }
}

impl Esm {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Full, Self::Half, Self::Log];

    fn format(self) -> TextureFormat {
        match self {
            Self::Full | Self::Log => TextureFormat::R32Float,
            Self::Half => TextureFormat::R16Float,
        }
    }

    /// The largest exponent that its numbers hold: see the module's page.
    fn largest_exponent(self) -> f64 {
        // More than exp() is off by, relative.
        const ROUNDING: f64 = 1.0 / 512.0;
        let (least, most) = match self {
            Self::Full => (
                256.0 * f64::from(f32::MIN_POSITIVE),
                f64::from(f32::MAX) / 30.0,
            ),
            Self::Half => (1.0 / 16384.0, 65504.0),
            Self::Log => return MOST_BY_DEPTH,
        };
        2.0 * ((-least.ln()).min(most.ln()) - ROUNDING)
    }

    /// The exponent that a frame chooses; none where each map has its own.
    fn exponent(self, frame: &Frame<'_>) -> Result<Option<f64>, PlanError> {
        let exponent = frame.setting(&EXPONENT)?;
        let most = self.largest_exponent();
        let instead = match self {
            Self::Full => "`esm_log` holds more",
            Self::Half => "`esm` and `esm_log` hold more",
            Self::Log => "depths are no finer",
        };
        PlanError::check(
            exponent <= most,
            "the setting `exponent`",
            exponent,
            &format!(
                "{most:.1} at the most with the filter `{}`, or 0 for the largest that is of use; {instead}",
                self.name()
            ),
        )?;
        Ok((exponent > 0.0).then_some(exponent))
    }
}

/// A frame's exponential filter.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Job {
    esm: Esm,
    /// The setting; none where a map's own is to be found.
    exponent: Option<f64>,
    width: Width,
}

impl Job {
    /// Adds to `plan` what turns its depth maps into exponentials, and filters them.
    fn add(self, plan: &mut ShadowPlan, maps: &Maps, cells: &[Cell]) {
        plan.textures
            .push(maps.texture(FILTERED, self.esm.format()));
        let tile = |i: usize| {
            let width = self.width.in_map(i);
            let map = maps.maps.get(i);
            let (exponent, ratio) = map.map_or((0.0, 0.0), |map| self.numbers(map, width));
            Value::Struct(
                Constants::new()
                    .with("exponent", Value::F32(exponent as f32))
                    .with("ratio", Value::F32(ratio as f32))
                    .with("width", Value::U32(width)),
            )
        };
        let tiles = Value::Array((0..MOST_MAPS).map(tile).collect());
        self.blur(plan, maps, &tiles, cells);
        plan.constants
            .extend(Constants::new().with("esm_tiles", tiles));
        if self.esm != Esm::Log {
            plan.samplers
                .push(SamplerDesc::new("esm_sampler", FilterMode::Linear));
        }
        if self.esm == Esm::Full {
            plan.needs.push(Need {
                features: Features::FLOAT32_FILTERABLE,
                instead: "the filter `esm_log`, or `esm_half` for ranges of few metres".to_owned(),
            });
        }
    }

    /// Adds what is computed: the cells of all maps along their rows, then along their columns, and then, where compute shaders
    /// cannot write the format, each map in the format.
    fn blur(self, plan: &mut ShadowPlan, maps: &Maps, tiles: &Value, cells: &[Cell]) {
        let Some(first) = maps.maps.first() else {
            return;
        };
        let side = first.tile.width;
        let cell = self.cell(side);
        let packed = |cell: &Cell| Value::U32(cell.column | cell.row << 12 | cell.map << 24);
        let mut list: Vec<_> = cells.iter().map(packed).collect();
        if list.is_empty() {
            // A shader's list has something in it.
            list.push(Value::U32(0));
        }
        let groups = [
            cell / GROUP * (cell / GROUP) / self.run(),
            list.len() as u32,
            1,
        ];
        plan.buffers.push(BufferDesc {
            name: CELLS.to_owned(),
            contents: BufferContents::Value(Value::Array(list)),
        });
        let mut compute = |shader: &str, binding: &str, target: &str| {
            if target != FILTERED {
                let scratch = maps.texture(target, TextureFormat::R32Float);
                plan.textures.push(scratch);
            }
            plan.passes.push(Pass::Compute(ComputePass {
                shader: shader.to_owned(),
                workgroups: groups.into(),
                writes: vec![target.into()],
                reads: Reads {
                    renamed: vec![(binding.to_owned(), target.into())],
                    constants: Constants::new()
                        .with("side", Value::U32(side))
                        .with("cell", Value::U32(cell))
                        .with("columns", Value::U32(maps.size[0] / side))
                        .with("tiles", tiles.clone()),
                },
            }));
        };
        let rounds = self.esm == Esm::Half;
        let means = if rounds { MEANS } else { FILTERED };
        if self.width.widest > 1 {
            compute("esm_across", ROWS, ROWS);
            compute("esm_down", FILTERED, means);
        } else {
            compute("esm_across", ROWS, means);
        }
        for map in maps.maps.iter().filter(|_| rounds) {
            let pass = ScreenPass::new("esm_round", FILTERED, map.tile, Constants::new());
            plan.passes.push(Pass::Screen(pass));
        }
    }

    /// A map's exponent, and what makes its depths linear.
    fn numbers(self, map: &Map, width: u32) -> (f64, f64) {
        let range = map.range;
        let exponent = self.exponent.unwrap_or_else(|| {
            let reach = WIDTHS * f64::from(width + 1) * range.texel;
            let wanted = DARK * (range.far - range.near) / reach;
            wanted.clamp(2.0 * DARK, self.esm.largest_exponent())
        });
        (exponent, range.ratio())
    }

    /// Texels along a cell of maps with `side` texels: a whole number of workgroups both ways, 64 or few more, and a 128th of
    /// the side at the least, so that there are no more cells than a dispatch may have workgroups.
    fn cell(self, side: u32) -> u32 {
        let group = GROUP * self.run();
        side.div_ceil(128).max(64).next_multiple_of(group)
    }

    /// The windows of an invocation: as the shader has them.
    fn run(self) -> u32 {
        if self.width.tapers {
            2
        } else {
            8.min(self.width.widest + 1)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The passes and the fetch hold the ends of the range in each format's numbers; a fiftieth more would be too much.
    #[test]
    fn the_largest_exponents_fit_their_formats() {
        let full = |exponent: f64| {
            let [least, most] = [-0.5, 0.5].map(|end| (end * exponent).exp() as f32);
            (30.0 * most).is_finite() && (least / 256.0).is_normal()
        };
        let half = |exponent: f64| {
            let [least, most] = [-0.5, 0.5].map(|end| (end * exponent).exp());
            most < 65504.0 && least > (-14_f64).exp2()
        };
        let largest = [Esm::Full, Esm::Half].map(Esm::largest_exponent);
        assert!(full(largest[0]) && !full(1.02 * largest[0]), "{largest:?}");
        assert!(half(largest[1]) && !half(1.02 * largest[1]), "{largest:?}");
    }
}

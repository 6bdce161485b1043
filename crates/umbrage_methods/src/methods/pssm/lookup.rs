//! Resources that the shader's lookup of a split's map reads.

use glam::{DMat4, DVec4, Mat4, Vec2, Vec4};
use umbrage_shadow::{
    Atlas, Blend, BufferContents, BufferDesc, ColorTarget, Constants, Contents, DepthOrder,
    DepthTarget, Frame, MAX_SPLITS, Map, Maps, Pass, PlanError, SamplerDesc, ShadowPlan,
    TextureDesc, TextureShape, Value, Viewport,
};
use wgpu_types::{ColorWrites, TextureFormat};

use super::{
    fit::{Job, Split, Splits, Transition},
    regions,
};
use crate::filters::Width;

/// The bindings of a map for each split.
const MAPS: [&str; FEW] = [
    "shadow_map_0",
    "shadow_map_1",
    "shadow_map_2",
    "shadow_map_3",
];

/// Lenses' matrices give reversed depth.
const ORDER: DepthOrder = DepthOrder::Reversed;

/// The most splits of lookups that have one vector, or one texture's channels, for all of them.
const FEW: usize = 4;

/// How a split's map is found: the axis `lookup`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Lookup {
    Branches,
    Channels,
    Masks,
    MatrixTexture,
    Packed,
    Storage,
    Weights,
}

impl Lookup {
    const ALL: [(&'static str, Self); 7] = [
        ("branches", Self::Branches),
        ("channels", Self::Channels),
        ("masks", Self::Masks),
        ("matrix_texture", Self::MatrixTexture),
        ("packed", Self::Packed),
        ("storage", Self::Storage),
        ("weights", Self::Weights),
    ];

    /// The lookup that a frame chooses, if it holds as many splits as are asked for.
    pub(super) fn of(frame: &Frame<'_>, splits: usize) -> Result<Self, PlanError> {
        let lookup = frame.choice("lookup", &Self::ALL)?;
        let name = frame.axis("lookup");
        let most = lookup.most_splits();
        PlanError::check(
            splits <= most,
            "the setting `splits`",
            splits,
            &format!(
                "{most} at the most with the lookup `{name}`; `packed`, `storage` and `matrix_texture` hold {MAX_SPLITS}"
            ),
        )?;
        Ok(lookup)
    }

    fn most_splits(self) -> usize {
        match self {
            Self::Branches | Self::Channels | Self::Masks | Self::Weights => FEW,
            Self::MatrixTexture | Self::Packed | Self::Storage => MAX_SPLITS,
        }
    }

    /// Fetches of one lookup in the map of a split.
    fn fetches(self, frame: &Frame<'_>, split: usize) -> Result<u32, PlanError> {
        let filter = |split| frame.filter()?.fetches(frame, split);
        match self {
            Self::Branches | Self::Masks | Self::Packed | Self::Storage => filter(split),
            Self::MatrixTexture => Ok(MATRIX_ROWS + filter(split)?),
            Self::Weights => (0..FEW).map(filter).sum(),
            Self::Channels => Ok((Width::of(frame)?.in_map(split) + 1).pow(2)),
        }
    }
}

/// Rows of a matrix texture: a matrix, and what else a comparison needs.
const MATRIX_ROWS: u32 = 5;

/// The plan of a frame's splits.
pub(super) fn plan(job: &Job<'_>, splits: &Splits) -> Result<ShadowPlan, PlanError> {
    let mut plan = ShadowPlan {
        filter_radius: job.frame.reach(0)?,
        shadow_distance: job.shadow_distance,
        regions: regions::of(job, splits)?,
        ..ShadowPlan::default()
    };
    let mut tiles = Tiles {
        columns: 1,
        size: [job.tile; 2],
    };
    match job.lookup {
        Lookup::Branches | Lookup::Weights => maps(&mut plan, job, splits),
        Lookup::Channels => channels(&mut plan, job, splits),
        Lookup::Masks | Lookup::MatrixTexture | Lookup::Packed | Lookup::Storage => {
            tiles = atlas(&mut plan, job, splits)?;
        }
    }
    match job.lookup {
        Lookup::MatrixTexture => matrix_texture(&mut plan, splits),
        Lookup::Storage => {
            let value = Value::Array(split_maps(splits, splits.splits.len().max(1)));
            plan.buffers.push(BufferDesc {
                name: "splits".to_owned(),
                contents: BufferContents::Value(value),
            });
        }
        _ => {}
    }
    // Where two splits are blended, the first two have the widest filters.
    let read = match job.transition {
        Transition::Blend => 2,
        Transition::Hard | Transition::Dither => 1,
    };
    let fetches = (0..read).map(|split| job.lookup.fetches(job.frame, split));
    plan.fetches_per_pixel = fetches.sum::<Result<_, _>>()?;
    plan.constants.extend(constants(job, splits, &tiles));
    Ok(plan)
}

/// How tiles lie in a texture.
struct Tiles {
    /// Tiles in a row.
    columns: u32,
    /// Texels across and down.
    size: [u32; 2],
}

/// All maps in one atlas.
fn atlas(plan: &mut ShadowPlan, job: &Job<'_>, splits: &Splits) -> Result<Tiles, PlanError> {
    let count = splits.splits.len() as u32;
    let (columns, maps) = if count == 0 {
        (1, Maps::none(job.follows_plane))
    } else {
        let margin = job.frame.margin(0)?.ceil() as u32;
        let atlas = Atlas::new(count, job.tile, margin)?;
        let maps = (0..).zip(&splits.splits);
        let maps = Maps {
            order: ORDER,
            shape: TextureShape::D2,
            size: atlas.size(),
            maps: maps.map(|(i, split)| map(split, atlas.tile(i))).collect(),
            follows_plane: job.follows_plane,
        };
        (atlas.columns(), maps)
    };
    job.frame.fill(&maps, plan)?;
    Ok(Tiles {
        columns,
        size: maps.size,
    })
}

/// A map for each split; the least that the shader can bind in the place of those that are not there.
fn maps(plan: &mut ShadowPlan, job: &Job<'_>, splits: &Splits) {
    plan.samplers.push(SamplerDesc::comparison(ORDER));
    for (i, name) in MAPS.into_iter().enumerate() {
        let split = splits.splits.get(i);
        let size = if split.is_some() { job.tile } else { 1 };
        plan.textures
            .push(TextureDesc::d2(name, Maps::FORMAT, [size, size]));
        if let Some(split) = split {
            let map = map(split, Viewport::square(job.tile));
            plan.passes.push(Pass::Casters(map.nearest(name, ORDER)));
        }
    }
}

/// A channel of one texture for each split, compared by hand.
fn channels(plan: &mut ShadowPlan, job: &Job<'_>, splits: &Splits) {
    const CHANNELS: [ColorWrites; FEW] = [
        ColorWrites::RED,
        ColorWrites::GREEN,
        ColorWrites::BLUE,
        ColorWrites::ALPHA,
    ];
    const NEAREST: &str = "shadow_depth";
    let side = if splits.splits.is_empty() {
        1
    } else {
        job.tile
    };
    let format = TextureFormat::Rgba32Float;
    let size = [side, side];
    plan.textures
        .push(TextureDesc::d2(Maps::BINDING, format, size));
    plan.textures
        .push(TextureDesc::d2(NEAREST, Maps::FORMAT, size));
    for (split, channels) in splits.splits.iter().zip(CHANNELS) {
        let mut pass = map(split, Viewport::square(job.tile)).nearest(NEAREST, ORDER);
        pass.shader = "caster_depth".to_owned();
        // One scratch for all of them.
        pass.depth = pass.depth.map(|depth| DepthTarget {
            clears: true,
            ..depth
        });
        pass.colors.push(ColorTarget {
            target: Maps::BINDING.into(),
            channels,
            blend: Blend::Replace,
        });
        plan.passes.push(Pass::Casters(pass));
    }
}

/// A split's map at `tile`.
fn map(split: &Split, tile: Viewport) -> Map {
    Map {
        tile,
        layer: 0,
        view_proj: split.view_proj,
        casters: split.casters.clone(),
        receivers: Some(split.depths),
        held: Some(split.held),
        bias: split.bias,
        range: split.range,
    }
}

/// The members of `PssmShadow`, for any lookup and transition.
fn constants(job: &Job<'_>, splits: &Splits, tiles: &Tiles) -> Constants {
    let columns = tiles.columns as f32;
    let texel = Vec2::from_array(tiles.size.map(|texels| 1.0 / texels as f32));
    let splits_of = |value: &dyn Fn(&Split) -> f64, none: f32| {
        let value = |i: usize| splits.splits.get(i).map_or(none, |s| value(s) as f32);
        let four = |i: usize| Vec4::from_array([0, 1, 2, 3].map(|j| value(4 * i + j)));
        Value::Array(vec![Value::Vec4(four(0)), Value::Vec4(four(1))])
    };
    let band = |split: &Split| split.depths[1] - job.band_length(split);
    let rate = |split: &Split| {
        if splits.has_next(split) {
            1.0 / job.band_length(split)
        } else {
            0.0
        }
    };
    let reach = splits
        .splits
        .last()
        .map_or(f32::MIN, |last| last.depths[1] as f32);
    Constants::new()
        .with("base", Value::Mat4(splits.base.as_mat4()))
        .with("forward", Value::Vec3(job.forward().as_vec3()))
        .with("reach", Value::F32(reach))
        .with("ends", splits_of(&|split| split.depths[1], f32::MAX))
        .with("bands", splits_of(&band, 0.0))
        .with("band_rates", splits_of(&rate, 0.0))
        .with("tile", Value::F32(job.tile as f32))
        .with("columns", Value::F32(columns))
        .with("rows_a_tile", Value::F32(1.0 / columns))
        .with("texel", Value::Vec2(texel))
        .with("crops", crops(splits))
        .with("crop_places", crop_columns(splits, 0))
        .with("crop_depths", crop_columns(splits, 1))
        .with("maps", Value::Array(split_maps(splits, FEW)))
}

/// Each split's crop, for all splits that there may be.
fn crops(splits: &Splits) -> Value {
    let crop = |i| {
        let split = splits.splits.get(i);
        let [place, depth] = split.map_or([Vec4::ZERO; 2], crop);
        let members = Constants::new().with("place", Value::Vec4(place));
        Value::Struct(members.with("depth", Value::Vec4(depth)))
    };
    Value::Array((0..MAX_SPLITS).map(crop).collect())
}

/// The two members of a `Crop`.
fn crop(split: &Split) -> [Vec4; 2] {
    let (scale, offset, bias) = (split.scale, split.offset, split.receiver_bias);
    let place = DVec4::new(scale.x, scale.y, offset.x, offset.y);
    let depth = DVec4::new(scale.z, offset.z, bias.x, bias.y);
    [place.as_vec4(), depth.as_vec4()]
}

/// A member of the first splits' crops, a column for each.
fn crop_columns(splits: &Splits, member: usize) -> Value {
    let column = |i: usize| {
        let split = splits.splits.get(i);
        split.map_or(Vec4::ZERO, |split| crop(split)[member])
    };
    Value::Mat4(Mat4::from_cols(column(0), column(1), column(2), column(3)))
}

/// The rows from the world to a split's map, before the division, and what else a `SplitMap` holds.
fn rows(base: &DMat4, split: &Split) -> [DVec4; MATRIX_ROWS as usize] {
    let (scale, offset, bias) = (split.scale, split.offset, split.receiver_bias);
    let row = |i: usize| base.row(i) * scale[i] + base.row(3) * offset[i];
    let rest = DVec4::new(scale.z / scale.x, scale.z / scale.y, bias.x, bias.y);
    [row(0), row(1), row(2), base.row(3), rest]
}

/// Rows that place everything beside the map, so that nothing is fetched from the map of a split that there is not.
const BESIDE: [DVec4; MATRIX_ROWS as usize] = {
    let mut rows = [DVec4::ZERO; MATRIX_ROWS as usize];
    rows[0] = DVec4::NEG_W;
    rows
};

/// A `SplitMap` for each of `count` splits.
fn split_maps(splits: &Splits, count: usize) -> Vec<Value> {
    let split_map = |i: usize| {
        let split = splits.splits.get(i);
        let [x, y, z, w, rest] = split.map_or(BESIDE, |split| rows(&splits.base, split));
        let matrix = DMat4::from_cols(x, y, z, w).transpose();
        let members = Constants::new().with("world_to_map", Value::Mat4(matrix.as_mat4()));
        Value::Struct(members.with("slope_and_bias", Value::Vec4(rest.as_vec4())))
    };
    (0..count).map(split_map).collect()
}

/// A column of numbers for each split.
fn matrix_texture(plan: &mut ShadowPlan, splits: &Splits) {
    const NAME: &str = "split_matrices";
    let columns: Vec<_> = splits
        .splits
        .iter()
        .map(|split| rows(&splits.base, split))
        .collect();
    let columns = if columns.is_empty() {
        vec![[DVec4::ZERO; MATRIX_ROWS as usize]]
    } else {
        columns
    };
    let size = [columns.len() as u32, MATRIX_ROWS];
    let texels = (0..MATRIX_ROWS as usize).flat_map(|row| columns.iter().map(move |c| c[row]));
    let numbers = texels.flat_map(|texel| texel.as_vec4().to_array());
    plan.contents.push(Contents {
        texture: NAME.to_owned(),
        bytes: numbers.flat_map(f32::to_le_bytes).collect(),
    });
    plan.textures
        .push(TextureDesc::d2(NAME, TextureFormat::Rgba32Float, size));
}

//! Passes that write depth as a colour.

mod common;

use common::probe::{number, probing, refusal, texture};
use glam::{Mat4, Vec3};
use umbrage_shadow::{
    Blend, CasterPass, ColorTarget, Constants, Contents, Cull, DepthOrder, DepthTarget, Frame,
    Pass, ShadowPlan, Value, Viewport,
};
use wgpu::{ColorWrites, TextureFormat};

/// Texels along the maps.
const SIZE: u32 = 8;

/// Tells a texel of the colour texture or, beyond its channels, of the depth texture: `which` is
/// 10 · column + channel, at row 3.
const CHANNELS: &str = r#"
struct Probe { which: u32 }
@group(1) @binding(0) var<uniform> probe: Probe;
@group(1) @binding(1) var color_map: texture_2d<f32>;
@group(1) @binding(2) var depth_map: texture_depth_2d;
fn calc_shadow(position_ws: vec3f) -> f32 {
    let texel = vec2u(probe.which / 10u, 3u);
    let channel = probe.which % 10u;
    if channel > 3u {
        return textureLoad(depth_map, texel, 0);
    }
    return textureLoad(color_map, texel, 0)[channel];
}
"#;

/// `depth` where the wall's front is, camera-relative z = −3, and 0.01 less a metre farther on.
fn flat(depth: f32) -> Mat4 {
    let scale = Mat4::from_scale(Vec3::new(0.01, 0.01, 0.01));
    Mat4::from_translation(Vec3::new(0.0, 0.0, depth + 0.03)) * scale
}

/// The wall in four channels, each with a depth of its own; the last one in the right half alone.
fn channels(frame: &Frame<'_>) -> ShadowPlan {
    let pass = |channel: u32| {
        let half = if channel == 3 { SIZE / 2 } else { 0 };
        let depth = 0.1 * (channel + 1) as f32;
        Pass::Casters(CasterPass {
            shader: "caster_depth".to_owned(),
            depth: Some(DepthTarget {
                clears: true,
                ..DepthOrder::Reversed.nearest("depth_map".into())
            }),
            colors: vec![ColorTarget {
                target: "color_map".into(),
                channels: ColorWrites::from_bits_truncate(1 << channel),
                blend: Blend::Replace,
            }],
            viewport: Viewport {
                x: half,
                y: 0,
                width: SIZE - half,
                height: SIZE,
            },
            cull: Cull::Nothing,
            // The wall fills a tenth of the map, scaled ten times: all of it.
            view_proj: Mat4::from_scale(Vec3::new(20.0, 20.0, 1.0)) * flat(depth),
            constants: Constants::new(),
            casters: vec![0],
            receivers: None,
        })
    };
    let which = frame.settings.get("which") as u32;
    ShadowPlan {
        textures: vec![
            texture("color_map", TextureFormat::Rgba32Float, SIZE, SIZE),
            texture("depth_map", TextureFormat::Depth32Float, SIZE, SIZE),
        ],
        passes: (0..4).map(pass).collect(),
        constants: Constants::new().with("which", Value::U32(which)),
        ..ShadowPlan::default()
    }
}

#[test]
fn depth_is_written_into_the_channels_that_a_pass_names() {
    let mut renderer = probing(CHANNELS, channels);
    let mut at =
        |column: u32, channel: u32| number(&mut renderer, f64::from(10 * column + channel));
    for (channel, depth) in [0.1_f32, 0.2, 0.3, 0.4].into_iter().enumerate() {
        let right = at(6, channel as u32);
        // A few roundings of a number below 1.
        assert!((right - depth).abs() < 1e-6, "channel {channel}: {right}");
        let left = at(1, channel as u32);
        let expected = if channel == 3 { 0.0 } else { right };
        assert_eq!(left, expected, "channel {channel}");
    }
    // The depth texture holds the last pass, bit for bit what its channel holds.
    assert_eq!([at(6, 4), at(1, 4)], [at(6, 3), 0.0]);
}

#[test]
fn colour_targets_that_do_not_fit_are_named() {
    type Spoil = fn(&mut ShadowPlan);
    fn color(plan: &mut ShadowPlan) -> &mut ColorTarget {
        let Some(Pass::Casters(pass)) = plan.passes.first_mut() else {
            unreachable!("the plan has passes")
        };
        pass.colors.first_mut().expect("it has a colour")
    }
    let cases: [(Spoil, &str); 7] = [
        (
            |plan| color(plan).target = "gone".into(),
            "the target `gone`, which is none of its textures",
        ),
        (
            |plan| {
                color(plan).target = "depth_map".into();
                plan.passes.truncate(1);
                if let Some(Pass::Casters(pass)) = plan.passes.first_mut() {
                    pass.depth = None;
                }
            },
            "a colour into `depth_map`, which is not of floats (Depth32Float)",
        ),
        (
            |plan| plan.textures[0].format = TextureFormat::Rgba32Uint,
            "a colour into `color_map`, which is not of floats (Rgba32Uint)",
        ),
        (
            |plan| plan.textures[0].width = 16,
            "into the 8 by 8 texels of `depth_map` and the 16 by 8 of `color_map`: both must be as large",
        ),
        (
            |plan| color(plan).channels = ColorWrites::empty(),
            "the channels `` of `color_map`, whose format Rgba32Float has `rgba`",
        ),
        (
            |plan| {
                plan.textures[0].format = TextureFormat::R32Float;
                color(plan).channels = ColorWrites::GREEN;
            },
            "the channels `g` of `color_map`, whose format R32Float has `r`",
        ),
        (
            |plan| {
                plan.contents = vec![Contents {
                    texture: "color_map".to_owned(),
                    bytes: vec![0; 16 * (SIZE * SIZE) as usize],
                }]
            },
            "contents for `color_map`, which a pass draws into as well",
        ),
    ];
    for (spoil, expected) in cases {
        let mut renderer = probing(CHANNELS, move |frame| {
            let mut plan = channels(frame);
            spoil(&mut plan);
            plan
        });
        let message = refusal(&mut renderer);
        assert!(message.contains(expected), "{message}\nlacks: {expected}");
    }
}

/// A pass may draw into a texture that a plan filled in the frame before: nothing of the texture's first
/// use stays in its way.
#[test]
fn a_texture_may_change_from_filled_to_drawn() {
    let mut renderer = probing(CHANNELS, |frame| {
        let mut plan = channels(frame);
        if frame.settings.get("which") < 10.0 {
            plan.passes.clear();
            plan.contents = vec![Contents {
                texture: "color_map".to_owned(),
                bytes: bytemuck::cast_slice(&[0.75_f32; 4 * (SIZE * SIZE) as usize]).to_vec(),
            }];
        }
        plan
    });
    assert_eq!(number(&mut renderer, 2.0), 0.75);
    assert!((number(&mut renderer, 62.0) - 0.3).abs() < 1e-6);
    assert_eq!(number(&mut renderer, 1.0), 0.75);
}

//! `basic`, drawn so that its map is a colour as well, and a shader that tells what the colour holds:
//! the key of a caster pass says nothing of who reads what it writes.

use umbrage::{
    compose::{Error, Package},
    methods::methods::basic::Basic,
    shadow::{
        Blend, ColorTarget, Frame, Light, Part, Pass, PlanError, Registry, Setting, ShadowMethod,
        ShadowPlan, Support, TextureDesc,
    },
};
use wgpu_types::{ColorWrites, TextureFormat};

/// The method `colored`, for lights with one map.
#[derive(Clone, Copy, Debug, Default)]
struct Colored;

impl Part for Colored {
    fn name(&self) -> &str {
        "colored"
    }
    fn settings(&self) -> &[Setting] {
        Basic.settings()
    }
    fn axes(&self) -> &[&str] {
        Basic.axes()
    }
}

impl ShadowMethod for Colored {
    fn supports(&self, light: &Light) -> Support {
        Basic.supports(light)
    }
    fn plan(&self, frame: &Frame<'_>) -> Result<ShadowPlan, PlanError> {
        let mut plan = Basic.plan(frame)?;
        let colors = plan.textures.iter().map(|map| TextureDesc {
            name: "color_map".to_owned(),
            format: TextureFormat::R32Float,
            ..map.clone()
        });
        let colors: Vec<_> = colors.collect();
        plan.textures.extend(colors);
        for pass in &mut plan.passes {
            if let Pass::Casters(pass) = pass {
                pass.shader = "caster_depth".to_owned();
                pass.colors.push(ColorTarget {
                    target: "color_map".into(),
                    channels: ColorWrites::RED,
                    blend: Blend::Replace,
                });
            }
        }
        plan.fetches_per_pixel = 1;
        Ok(plan)
    }
}

/// All methods, and `colored`.
///
/// # Panics
/// Where another method is called the same.
pub fn registry() -> Registry {
    let mut registry = umbrage::methods::registry().expect("names are unique");
    registry.methods.add(Colored).expect("names are unique");
    registry
}

/// The package of its shader, whose term is the depth in the texel that the receiver falls into.
///
/// # Errors
/// Where the package does not fit together.
pub fn colored_package() -> Result<Package, Error> {
    let axes = r#"(axes: { "method": (values: {
        "colored": (bind: { "umbrage::interface::shadow": "package::colored" }),
    }) })"#;
    let shader = "
        struct Colored { world_to_map: mat4x4f }
        @group(1) @binding(0) var<uniform> colored: Colored;
        @group(1) @binding(1) var color_map: texture_2d<f32>;
        fn calc_shadow(position_ws: vec3f) -> f32 {
            let at = colored.world_to_map * vec4f(position_ws, 1.0);
            let texel = vec2i(floor(at.xy / at.w * vec2f(textureDimensions(color_map))));
            return textureLoad(color_map, texel, 0).r;
        }";
    let files = [("axes.ron", axes), ("colored.wesl", shader)];
    let files = files.map(|(path, text)| (path.to_owned(), text.to_owned()));
    Package::from_sources("colored", "colored", files)
}

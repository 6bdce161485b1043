//! One depth map, compared with the receiver's depth (Williams 1978), filtered by percentage-closer
//! filtering (Reeves et al. 1987). Its shader half is `methods/basic.wesl`; [`crate::basic_twin`] is
//! the same computation on the CPU.
//!
//! # How it works
//! Depth as seen from the light goes into a map: one rectangle for directional and spot lights, a
//! cube for point lights. The map is fitted to the *receivers seen*: what of each receiver's box lies in
//! the camera's frustum, and in the light's. A directional map spans their rectangle; a spot map is the
//! same rectangle cut out of the light's perspective; a cube's faces cannot be fitted. The near plane
//! stands at the nearest caster that lies between the light and what the map holds, so that nothing is
//! cut away that could cast (and no depth clamp is asked for); the far plane stands behind the farthest
//! receiver. The map follows the view from frame to frame, so its edges shimmer as the camera moves.
//!
//! # Settings and axes
//! `resolution` (texels), `depth_bias` (texels: a texel's width, towards the light); the filter's width
//! is the axis `pcf`, and `receiver_bias` says whether the depth compared follows the receiver's plane
//! (`plane`) or not (`constant`).
//!
//! With `plane`, each fetch is compared with the plane's depth a texel nearer to the light on both axes,
//! which no texel of the plane's own exceeds; up to 87° between the light and the normal, where that is
//! 19 texels' widths. What `depth_bias` has to cover is the rasteriser, which moves vertices on its own
//! grid, 1/256 texel on most devices: at a slope of 19 that is 19 · √2 / 512 = 0.05 texels. What else it has to cover is that a curved receiver is no plane: a
//! facet that rises from the receiver's by the slope s lies s · W / 2 texels nearer to the light at the
//! filter's edge. The default of 1.5 takes in s = 0.6 (31°) at W = 5, and is little against that
//! filter's width.
//!
//! # Cost
//! One map and one pass; six passes for a cube. ((W + 1) / 2)² fetches a pixel for width W, W² from a
//! cube, whose faces a wider fetch cannot cross.
//!
//! # Limits
//! Receivers at more than 87° to the light are compared at their own depth plus `depth_bias`, and so may
//! be mottled; they get a twentieth of the light at the most, and none if they are turned away. Up to there, what shades a receiver from
//! less than two slopes' texels above it may be missed at its steep places.
//!
//! What is nearer to a spot or point light than 1e-5 of its range casts no shadow.

use glam::{DMat4, DVec2, DVec3, DVec4, Mat4, Vec2, Vec3};
use umbrage_shadow::{
    Aabb, Beam, CasterPass, Constants, DepthTest, Extent, Frame, Frustum, Lens, Light, LightKind,
    Pass, PlanError, Rect, SamplerDesc, Setting, ShadowMethod, ShadowPlan, Support, TextureDesc,
    TextureShape, Value, Viewport,
};
use wgpu_types::{CompareFunction, FilterMode, TextureFormat};

/// The method `basic`.
#[derive(Clone, Copy, Debug, Default)]
pub struct Basic;

/// The binding of the map.
const MAP: &str = "shadow_map";

const SETTINGS: [Setting; 2] = [
    Setting {
        name: "resolution",
        doc: "texels along each side of the map",
        min: 1.0,
        max: 16384.0,
        default: 2048.0,
        whole: true,
    },
    Setting {
        name: "depth_bias",
        doc: "how far a receiver is moved towards the light before it is compared, in texels",
        min: 0.0,
        max: 64.0,
        default: 1.5,
        whole: false,
    },
];

/// The nearest near plane of a spot or point light, as a share of its range. Reversed depth keeps its
/// relative precision over this ratio, and more.
const NEAREST: f64 = 1e-5;

/// How much farther than needed the near and far planes stand, relative: beyond any rounding.
const PADDING: f64 = 1.0 / 8192.0;

impl ShadowMethod for Basic {
    fn name(&self) -> &str {
        "basic"
    }

    fn settings(&self) -> &[Setting] {
        &SETTINGS
    }

    fn axes(&self) -> &[&str] {
        &["pcf", "receiver_bias"]
    }

    fn supports(&self, _: &Light) -> Support {
        Support::Yes
    }

    fn plan(&self, frame: &Frame<'_>) -> Result<ShadowPlan, PlanError> {
        let job = Job::new(frame)?;
        let plan = match frame.light.kind {
            LightKind::Directional { direction } => job.directional(direction.normalize()),
            LightKind::Spot {
                position,
                direction,
                outer_angle,
                range,
                ..
            } => job.spot(
                position - job.origin,
                direction.normalize(),
                outer_angle,
                range,
            ),
            LightKind::Point { position, range } => job.point(position - job.origin, range),
        };
        Ok(plan)
    }
}

/// A frame's numbers, checked; all else is camera-relative.
struct Job {
    origin: DVec3,
    camera: Frustum,
    casters: Vec<Aabb>,
    receivers: Vec<Aabb>,
    resolution: u32,
    depth_bias: f64,
    width: u32,
}

impl Job {
    fn new(frame: &Frame<'_>) -> Result<Self, PlanError> {
        frame.validate()?;
        for setting in &SETTINGS {
            let value = frame.settings.get(setting.name);
            let what = format!("the setting `{}`", setting.name);
            let holds = (setting.min..=setting.max).contains(&value);
            PlanError::check(
                holds,
                &what,
                value,
                &format!("{} to {}", setting.min, setting.max),
            )?;
        }
        let pcf = frame.axes.get("pcf").map_or("missing", String::as_str);
        let width = pcf.parse().unwrap_or(0);
        PlanError::check(
            width % 2 == 1 && width <= 15,
            "the axis `pcf`",
            pcf,
            "odd, 1 to 15",
        )?;
        let origin = frame.view.position;
        let lit = frame
            .casters
            .receivers
            .iter()
            .filter(|r| frame.light.reaches(r));
        Ok(Self {
            origin,
            camera: frame.view.frustum_relative(),
            casters: frame
                .casters
                .casters
                .iter()
                .map(|c| c.translate(-origin))
                .collect(),
            receivers: lit.map(|r| r.translate(-origin)).collect(),
            resolution: frame.settings.get("resolution") as u32,
            depth_bias: frame.settings.get("depth_bias"),
            width,
        })
    }

    fn directional(&self, direction: DVec3) -> ShadowPlan {
        let lens = Lens::directional(direction);
        let Some(mut seen) = Extent::of(&lens, DVec3::ZERO, &self.receivers, &[&self.camera])
        else {
            return self.unshadowed(TextureShape::D2);
        };
        let least = seen.precision;
        self.expand(&mut seen, least);
        let corners = self.casters.iter().flat_map(Aabb::corners);
        let nearest = corners.map(|p| lens.place(p).1).fold(seen.near, f64::min);
        let padding = PADDING * (seen.far - nearest) + 4.0 * seen.precision;
        seen.far += padding;
        let beam = Beam::new(
            &lens,
            &seen.rect,
            nearest - padding,
            seen.far,
            &self.casters,
        );
        seen.near = seen.near.min(beam.near);
        seen.near -= PADDING * (seen.far - seen.near) + 4.0 * seen.precision;

        let texel = seen.rect.size().max_element() / f64::from(self.resolution);
        let rounding = seen
            .precision
            .max(Extent::PRECISION * seen.near.abs().max(seen.far.abs()));
        let range = seen.far - seen.near;
        let shift = self.depth_bias * texel + 4.0 * rounding;
        let bias = DVec2::new(shift / range, 0.0);
        let texel_depth = DVec2::new(texel / range, 0.0);
        self.map(&lens, &seen, beam.casters, bias, texel_depth)
    }

    fn spot(&self, position: DVec3, direction: DVec3, angle: f64, range: f64) -> ShadowPlan {
        let lens = Lens::spot(position, direction);
        let floor = NEAREST * range;
        let cone = Frustum::from_matrix(lens.matrix(&Rect::square(angle.tan()), floor, range));
        let Some(mut seen) = Extent::of(&lens, position, &self.receivers, &[&self.camera, &cone])
        else {
            return self.unshadowed(TextureShape::D2);
        };
        let least = seen.precision / seen.far;
        self.expand(&mut seen, least);
        let texel = seen.rect.size().max_element() / f64::from(self.resolution);
        let nearest_receiver = seen.near;
        seen.far *= 1.0 + PADDING;
        let beam = Beam::new(&lens, &seen.rect, floor, seen.far, &self.casters);
        seen.near = (seen.near.min(beam.near) * (1.0 - PADDING)).max(floor);
        let bias = self.perspective_bias(&lens, &seen, texel, nearest_receiver);
        // A texel is `texel` · d wide at distance d, where depth is A + B / d and falls by B / d² a metre.
        let texel_depth = texel * DVec2::new(-lens.depth_terms(seen.near, seen.far).x, 1.0);
        self.map(&lens, &seen, beam.casters, bias, texel_depth)
    }

    /// A face that no filter's tap can reach has no pass: `reached` widens each face by what a filter
    /// reads beyond its edge.
    fn point(&self, position: DVec3, range: f64) -> ShadowPlan {
        let lenses = Lens::cube(position);
        let floor = NEAREST * range;
        let texel = 2.0 / f64::from(self.resolution);
        let reached = Rect::square(1.0 + texel * self.margin());
        let face = Rect::square(1.0);
        let seen = lenses.each_ref().map(|lens| {
            let volume = Frustum::from_matrix(lens.matrix(&reached, floor, range));
            Extent::of(lens, position, &self.receivers, &[&self.camera, &volume])
        });
        // All faces share one range of depths: a filter's taps cross from face to face.
        let Some(mut all) = seen.into_iter().flatten().reduce(Extent::union) else {
            return self.unshadowed(TextureShape::Cube);
        };
        let nearest_receiver = all.near;
        all.far *= 1.0 + PADDING;
        let beams = std::array::from_fn::<_, 6, _>(|i| {
            let beam = |_| Beam::new(&lenses[i], &face, floor, all.far, &self.casters);
            seen[i].map_or(Beam::EMPTY, beam)
        });
        let nearest = beams.iter().map(|beam| beam.near).fold(all.near, f64::min);
        all.near = (nearest * (1.0 - PADDING)).max(floor);

        let bias = self.perspective_bias(&lenses[0], &all, texel, nearest_receiver);
        let projection = lenses[0].depth_terms(all.near, all.far);
        let constants = cube_constants(position.as_vec3(), projection.as_vec2(), bias.as_vec2());
        let passes = lenses
            .iter()
            .zip(beams)
            .enumerate()
            .filter(|(layer, _)| seen[*layer].is_some())
            .map(|(layer, (lens, beam))| {
                self.pass(
                    layer as u32,
                    lens.matrix(&face, all.near, all.far),
                    beam.casters,
                )
            });
        self.plan(
            TextureShape::Cube,
            self.resolution,
            passes.collect(),
            constants,
        )
    }

    /// How far from its middle a filter reads, texels: half its width, a texel's fetch, and room for
    /// rounding.
    fn margin(&self) -> f64 {
        0.5 * f64::from(self.width) + 1.5
    }

    /// Widens the map by its filter's margin, and until its texels are no finer than `least`.
    fn expand(&self, seen: &mut Extent, least: f64) {
        let resolution = f64::from(self.resolution);
        // A map hardly wider than its filter keeps half of itself for what it is to hold.
        let margin = self.margin().min(0.25 * resolution);
        let size = seen.rect.size().max(DVec2::splat(least * resolution));
        seen.rect = seen
            .rect
            .resized(size * resolution / (resolution - 2.0 * margin));
    }

    /// At distance d, depth is A + B / d and a texel is `texel` · d wide, so a shift of k texels is one
    /// by a share s = k · `texel` of d: A + B / (d (1 − s)) = depth + (depth − A) s / (1 − s).
    /// Rounding adds to s; it is worst for the receiver nearest to the light.
    fn perspective_bias(&self, lens: &Lens, seen: &Extent, texel: f64, nearest: f64) -> DVec2 {
        let rounding = Extent::PRECISION + seen.precision / nearest.max(1e-3 * seen.far);
        // Beyond the whole distance a shift has no meaning.
        let share = (self.depth_bias * texel + 4.0 * rounding).min(0.9);
        let raise = share / (1.0 - share);
        DVec2::new(-raise * lens.depth_terms(seen.near, seen.far).x, raise)
    }

    /// The plan of one rectangular map.
    fn map(
        &self,
        lens: &Lens,
        seen: &Extent,
        casters: Vec<usize>,
        bias: DVec2,
        texel_depth: DVec2,
    ) -> ShadowPlan {
        let clip = lens.matrix(&seen.rect, seen.near, seen.far);
        // Clip space to the map: u right, v down, both 0..1 after the division by w.
        let texture = DMat4::from_cols(
            DVec4::new(0.5, 0.0, 0.0, 0.0),
            DVec4::new(0.0, -0.5, 0.0, 0.0),
            DVec4::Z,
            DVec4::new(0.5, 0.5, 0.0, 1.0),
        );
        let world_to_map = texture * clip;
        let plane_to_map = world_to_map.inverse().transpose();
        let constants = map_constants(
            world_to_map.as_mat4(),
            plane_to_map.as_mat4(),
            bias.as_vec2(),
            texel_depth.as_vec2(),
        );
        let passes = vec![self.pass(0, clip, casters)];
        self.plan(TextureShape::D2, self.resolution, passes, constants)
    }

    /// The plan where no receiver is seen: the least that the shader can read, and it reads light.
    fn unshadowed(&self, shape: TextureShape) -> ShadowPlan {
        let constants = match shape {
            // w = 0: beside every map.
            TextureShape::D2 => map_constants(Mat4::ZERO, Mat4::ZERO, Vec2::ZERO, Vec2::ZERO),
            // Depth 1: nothing is nearer.
            TextureShape::Cube => cube_constants(Vec3::ZERO, Vec2::ZERO, Vec2::X),
        };
        self.plan(shape, 1, Vec::new(), constants)
    }

    /// Both sides of each triangle are drawn: a mesh may be open, a leaf without thickness, a transform
    /// a mirror.
    fn pass(&self, layer: u32, view_proj: DMat4, casters: Vec<usize>) -> Pass {
        Pass::Casters(CasterPass {
            target: MAP.to_owned(),
            layer,
            viewport: Viewport {
                x: 0,
                y: 0,
                width: self.resolution,
                height: self.resolution,
            },
            clear: Some(0.0),
            depth_test: DepthTest {
                compare: CompareFunction::GreaterEqual,
                unclipped: false,
            },
            cull: None,
            view_proj: view_proj.as_mat4(),
            casters,
            color: None,
            receivers: None,
        })
    }

    fn plan(
        &self,
        shape: TextureShape,
        size: u32,
        passes: Vec<Pass>,
        constants: Constants,
    ) -> ShadowPlan {
        let format = TextureFormat::Depth32Float;
        let map = TextureDesc {
            name: MAP.to_owned(),
            format,
            width: size,
            height: size,
            shape,
        };
        let sampler = SamplerDesc {
            name: "shadow_sampler".to_owned(),
            filter: FilterMode::Linear,
            compare: Some(CompareFunction::GreaterEqual),
        };
        let taps = match shape {
            TextureShape::D2 => self.width.div_ceil(2),
            TextureShape::Cube => self.width,
        };
        ShadowPlan {
            textures: vec![map],
            samplers: vec![sampler],
            passes,
            constants,
            fetches_per_pixel: taps * taps,
            filter_radius: 0.5 * f64::from(self.width) + 0.5,
            ..ShadowPlan::default()
        }
    }
}

/// The members of `BasicShadow` for a rectangular map.
fn map_constants(
    world_to_map: Mat4,
    plane_to_map: Mat4,
    bias: Vec2,
    texel_depth: Vec2,
) -> Constants {
    Constants::new()
        .with("world_to_map", Value::Mat4(world_to_map))
        .with("plane_to_map", Value::Mat4(plane_to_map))
        .with("bias", Value::Vec2(bias))
        .with("texel_depth", Value::Vec2(texel_depth))
}

/// The members of `BasicShadow` for a cube.
fn cube_constants(light_position: Vec3, projection: Vec2, bias: Vec2) -> Constants {
    Constants::new()
        .with("light_position", Value::Vec3(light_position))
        .with("projection", Value::Vec2(projection))
        .with("bias", Value::Vec2(bias))
}

//! One depth map, compared with the receiver's depth (Williams 1978), filtered by percentage-closer
//! filtering (Reeves et al. 1987). Its shader half is `methods/basic.wesl`.
//!
//! # How it works
//! Depth as seen from the light goes into a map: one rectangle for directional and spot lights, a
//! cube for point lights. The map is fitted to the *receivers seen*: what of each receiver's box lies in
//! the camera's frustum, and in the light's. A directional map spans their rectangle, as far as casters lie in the same
//! part of the light's plane: beside all casters is no shadow, and the shader samples no map. A spot map is the
//! receivers' rectangle cut out of the light's perspective; a cube's faces cannot be fitted. The near plane
//! stands at the nearest caster that lies between the light and what the map holds, so that nothing is
//! cut away that could cast (and no depth clamp is asked for); the far plane stands behind the farthest
//! receiver. The map follows the view from frame to frame, so its edges shimmer as the camera moves.
//!
//! So a ground that shades nothing is best told not to cast: the map is then as large as what stands on it. Of the
//! examples, `bunny_sun` has 0.072 % wrong samples in place of 0.243 %, and 1.3 fetches a pixel in place of 4; `leaves`
//! 0.058 % in place of 0.288 % (`casts: false` for the ground, 2048² texels, W = 3; `umbrage compare --size 480x270`).
//!
//! # Settings and axes
//! `resolution` (texels), `depth_bias` (texels: a texel's width, towards the light); the filter's width
//! is the axis `pcf`, and `receiver_bias` says whether the depth compared follows the receiver's plane
//! (`plane`) or not (`constant`).
//!
//! With `plane`, each fetch is compared with the plane's depth a texel nearer to the light on both axes, which no
//! texel of the plane's own exceeds, nor do those that the rasteriser's grid displaces (1/256 texel on most
//! devices). From 89.1° between the light and the normal on, where that is 64 texels' widths, the map is sampled a
//! step aside instead, so that no plane shades itself up to the horizon: [`super`] has the derivation, and what
//! else was tried. `depth_bias` has to cover that a curved receiver is no plane: a facet that rises from
//! the receiver's by the slope s lies s · W / 2 texels nearer to the light at the filter's edge. The default of 1.5
//! takes in s = 0.6 (31°) at W = 5, and is little against that filter's width. Exponential maps ([`crate::filters::esm`]) take no bias.
//!
//! # Cost
//! One map and one pass; six passes for a cube. ((W + 1) / 2)² fetches a pixel for width W, W² from a
//! cube, whose faces a wider fetch cannot cross.
//!
//! # Limits
//! Casters nearer to a receiver than two slopes' texels along the ray may be missed; at more than 89.1° to the light,
//! so may casters less than √2 (W + 1) / 2 texels off its plane. A shadow narrower across the light than half of the
//! filter is washed out: in flat light, so are the shadows of low casters, however long they are. Where a wall meets
//! another surface, the filter follows the wall's plane past the corner and finds the other surface before it: at
//! grazing angles, a darker rim at the wall's foot.
//!
//! Casters nearer to a spot or point light than 1e-5 of its range cast no shadow: so neither does the surface that
//! the light lies on, be it a wall, an edge or a corner. A caster that near, but off the light, shades in truth only.

use glam::{DMat4, DVec2, DVec3, DVec4, Mat4, Vec2, Vec3, Vec4};
use umbrage_shadow::{
    Beam, Bias, Bounds, Choice, Constants, DepthOrder, Extent, Frame, Frustum, Lens, Light,
    LightKind, Map, MapRange, Maps, Part, Placed, PlanError, Rect, Setting, ShadowMethod,
    ShadowPlan, Support, TextureShape, Value, Viewport,
};

use crate::filters::Width;

/// The method `basic`.
#[derive(Clone, Copy, Debug, Default)]
pub struct Basic;

const RESOLUTION: Setting = Setting {
    name: "resolution",
    doc: "texels along each side of the map",
    min: 1.0,
    max: 16384.0,
    default: 2048.0,
    whole: true,
};

const DEPTH_BIAS: Setting = Setting {
    name: "depth_bias",
    doc: "how far a receiver is moved towards the light before it is compared, in texels",
    min: 0.0,
    max: 64.0,
    default: 1.5,
    whole: false,
};

impl Part for Basic {
    fn name(&self) -> &str {
        "basic"
    }

    fn settings(&self) -> &[Setting] {
        &[RESOLUTION, DEPTH_BIAS]
    }

    fn axes(&self) -> &[&str] {
        &[Choice::DEPTH, Choice::FILTER, "receiver_bias"]
    }
}

impl ShadowMethod for Basic {
    fn supports(&self, _: &Light) -> Support {
        Support::Yes
    }

    fn plan(&self, frame: &Frame<'_>) -> Result<ShadowPlan, PlanError> {
        let job = Job::new(frame)?;
        match frame.light.kind {
            LightKind::Directional { direction } => job.directional(direction.normalize()),
            LightKind::Spot {
                position,
                direction,
                outer_angle,
                range,
                ..
            } => job.spot(
                position - job.bounds.origin,
                direction.normalize(),
                outer_angle,
                range,
            ),
            LightKind::Point { position, range } => job.point(position - job.bounds.origin, range),
        }
    }
}

/// A frame's numbers, checked; all else is camera-relative.
struct Job<'a> {
    frame: &'a Frame<'a>,
    bounds: Bounds,
    resolution: u32,
    depth_bias: f64,
    /// See [`Frame::margin`].
    margin: f64,
    follows_plane: bool,
}

impl<'a> Job<'a> {
    fn new(frame: &'a Frame<'a>) -> Result<Self, PlanError> {
        frame.validate()?;
        let resolution = frame.setting(&RESOLUTION)? as u32;
        let depth_bias = frame.setting(&DEPTH_BIAS)?;
        let biases = [("constant", false), ("plane", true)];
        Ok(Self {
            frame,
            bounds: frame.bounds(),
            resolution,
            depth_bias: frame.depth_bias(depth_bias, resolution)?,
            margin: frame.margin(0)?,
            follows_plane: frame.choice("receiver_bias", &biases)?,
        })
    }

    fn directional(&self, direction: DVec3) -> Result<ShadowPlan, PlanError> {
        let lens = Lens::directional(direction);
        let (receivers, volumes) = (&self.bounds.receivers, [&self.bounds.camera]);
        let Some(mut seen) = Extent::of(&lens, DVec3::ZERO, receivers, &volumes) else {
            return self.unshadowed();
        };
        let casters = Placed::new(&lens, &self.bounds.casters);
        let shaded = casters.bound().map(|bound| Rect::of(&bound));
        let Some(rect) = shaded.and_then(|shaded| shaded.intersection(&seen.rect)) else {
            return self.unshadowed();
        };
        seen.rect = rect;
        let least = seen.precision();
        self.expand(&mut seen, least);
        let casters = seen.take_casters(0.0, &casters);
        let texel = seen.rect.size().max_element() / f64::from(self.resolution);
        let bias = Bias::new(&lens, &seen, self.depth_bias, texel, 0.0);
        self.map(&lens, &seen, casters, bias)
    }

    fn spot(
        &self,
        position: DVec3,
        direction: DVec3,
        angle: f64,
        range: f64,
    ) -> Result<ShadowPlan, PlanError> {
        let lens = Lens::spot(position, direction);
        let floor = Extent::NEAREST * range;
        let cone = Frustum::from_matrix(lens.matrix(&Rect::square(angle.tan()), floor, range));
        let Some(mut seen) = Extent::of(
            &lens,
            position,
            &self.bounds.receivers,
            &[&self.bounds.camera, &cone],
        ) else {
            return self.unshadowed();
        };
        let least = seen.precision() / seen.far;
        self.expand(&mut seen, least);
        let texel = seen.rect.size().max_element() / f64::from(self.resolution);
        let nearest_receiver = seen.near;
        let casters = seen.take_casters(floor, &Placed::new(&lens, &self.bounds.casters));
        let bias = Bias::new(&lens, &seen, self.depth_bias, texel, nearest_receiver);
        self.map(&lens, &seen, casters, bias)
    }

    /// A face that no filter's tap can reach has no pass: `reached` widens each face by what a filter
    /// reads beyond its edge.
    fn point(&self, position: DVec3, range: f64) -> Result<ShadowPlan, PlanError> {
        let lenses = Lens::cube(position);
        let floor = Extent::NEAREST * range;
        let texel = 2.0 / f64::from(self.resolution);
        let reached = Rect::square(1.0 + texel * self.margin);
        let face = Rect::square(1.0);
        let seen = lenses.each_ref().map(|lens| {
            let volume = Frustum::from_matrix(lens.matrix(&reached, floor, range));
            Extent::of(
                lens,
                position,
                &self.bounds.receivers,
                &[&self.bounds.camera, &volume],
            )
        });
        // All faces share one range of depths: a filter's taps cross from face to face.
        let Some(mut all) = seen.into_iter().flatten().reduce(Extent::union) else {
            // Depth 1: nothing is nearer.
            let constants = cube_constants(Vec3::ZERO, Vec2::ZERO, Vec2::X);
            return self.cube(1, Vec::new(), constants);
        };
        let nearest_receiver = all.near;
        all.far *= 1.0 + Extent::PADDING;
        let beams = std::array::from_fn::<_, 6, _>(|i| {
            let casters = |lens| Placed::new(lens, &self.bounds.casters);
            let beam = |_| Beam::new(&casters(&lenses[i]), &face, floor, all.far);
            seen[i].map_or(Beam::EMPTY, beam)
        });
        let nearest = beams.iter().map(|beam| beam.near).fold(all.near, f64::min);
        all.near = (nearest * (1.0 - Extent::PADDING)).max(floor);

        let bias = Bias::new(&lenses[0], &all, self.depth_bias, texel, nearest_receiver);
        let projection = lenses[0].depth_terms(all.near, all.far);
        let constants = cube_constants(
            position.as_vec3(),
            projection.as_vec2(),
            self.frame.receiver_bias(&bias)?.as_vec2(),
        );
        let faces = lenses.iter().zip(beams).enumerate();
        let faces = faces.filter(|(layer, _)| seen[*layer].is_some());
        let maps = faces.map(|(layer, (lens, beam))| Map {
            tile: Viewport::square(self.resolution),
            layer: layer as u32,
            view_proj: lens.matrix(&face, all.near, all.far),
            casters: beam.casters,
            receivers: None,
            held: None,
            bias,
            range: MapRange::new(lens, &all, self.resolution),
        });
        self.cube(self.resolution, maps.collect(), constants)
    }

    /// Texels along a map below which rounding is told from the map's side, not from a texel.
    const FEW: f64 = 32.0;

    /// Widens the map by its filter's margin, and until its texels are no finer than `least`, the exactness of positions;
    /// where it has few, until that is a small part of the whole.
    fn expand(&self, seen: &mut Extent, least: f64) {
        let resolution = f64::from(self.resolution);
        // A map hardly wider than its filter keeps half of itself for what it is to hold.
        let margin = self.margin.min(0.25 * resolution);
        let size = seen
            .rect
            .size()
            .max(DVec2::splat(least * resolution.max(Self::FEW)));
        seen.rect = seen
            .rect
            .resized(size * resolution / (resolution - 2.0 * margin));
    }

    /// The plan of one rectangular map.
    fn map(
        &self,
        lens: &Lens,
        seen: &Extent,
        casters: Vec<usize>,
        bias: Bias,
    ) -> Result<ShadowPlan, PlanError> {
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
            [world_to_map.as_mat4(), plane_to_map.as_mat4()],
            self.frame.receiver_bias(&bias)?.as_vec2(),
            bias.texel.as_vec2(),
            self.resolution,
        );
        let map = Map {
            tile: Viewport::square(self.resolution),
            layer: 0,
            view_proj: clip,
            casters,
            receivers: None,
            held: None,
            bias,
            range: MapRange::new(lens, seen, self.resolution),
        };
        let maps = Maps {
            // Lenses' matrices give reversed depth.
            order: DepthOrder::Reversed,
            shape: TextureShape::D2,
            size: [self.resolution; 2],
            maps: vec![map],
            follows_plane: self.follows_plane,
        };
        self.plan(
            &maps,
            constants,
            self.frame.filter()?.fetches(self.frame, 0)?,
        )
    }

    /// The plan where no receiver is seen, or none that could be in shadow: the least that the shader can read, and it reads light.
    fn unshadowed(&self) -> Result<ShadowPlan, PlanError> {
        // All points lie beside the map.
        let mut nowhere = Mat4::ZERO;
        nowhere.w_axis = Vec4::new(-1.0, -1.0, 0.0, 1.0);
        let constants = map_constants([nowhere, Mat4::ZERO], Vec2::ZERO, Vec2::ZERO, 1);
        let fetches = self.frame.filter()?.fetches(self.frame, 0)?;
        self.plan(&Maps::none(self.follows_plane), constants, fetches)
    }

    /// The plan of a cube of `size` texels a side. Its shader filters by hand, across the faces' edges.
    fn cube(
        &self,
        size: u32,
        maps: Vec<Map>,
        constants: Constants,
    ) -> Result<ShadowPlan, PlanError> {
        let maps = Maps {
            // Lenses' matrices give reversed depth.
            order: DepthOrder::Reversed,
            shape: TextureShape::Cube,
            size: [size; 2],
            maps,
            follows_plane: self.follows_plane,
        };
        self.plan(&maps, constants, Width::of(self.frame)?.widest.pow(2))
    }

    fn plan(
        &self,
        maps: &Maps,
        constants: Constants,
        fetches_per_pixel: u32,
    ) -> Result<ShadowPlan, PlanError> {
        let mut plan = ShadowPlan {
            constants,
            fetches_per_pixel,
            ..ShadowPlan::default()
        };
        self.frame.fill(maps, &mut plan)?;
        Ok(plan)
    }
}

/// The members of `BasicShadow` for a rectangular map, `side` texels along: world to map, planes to map.
fn map_constants(
    [world_to_map, plane_to_map]: [Mat4; 2],
    bias: Vec2,
    texel_depth: Vec2,
    side: u32,
) -> Constants {
    Constants::new()
        .with("world_to_map", Value::Mat4(world_to_map))
        .with("plane_to_map", Value::Mat4(plane_to_map))
        .with("bias", Value::Vec2(bias))
        .with("texel_depth", Value::Vec2(texel_depth))
        .with("side", Value::F32(side as f32))
        .with("texel", Value::F32(1.0 / side as f32))
}

/// The members of `BasicShadow` for a cube.
fn cube_constants(light_position: Vec3, projection: Vec2, bias: Vec2) -> Constants {
    Constants::new()
        .with("light_position", Value::Vec3(light_position))
        .with("projection", Value::Vec2(projection))
        .with("bias", Value::Vec2(bias))
}

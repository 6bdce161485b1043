//! The shadow term of a stage on the CPU: rays from the camera find the receivers, rays through the
//! middle of each texel find what the map holds, and the method's twin filters it. Nothing of the GPU is
//! used, so that a fault on either side shows.

use std::cell::{Cell, RefCell};
use std::collections::{BTreeMap, HashMap};

use glam::{DMat4, DVec2, DVec3, Vec2};
use umbrage::shadow::{Answers, Casters, Frame, Pass, Registry, Settings, ShadowPlan, View};
use umbrage_testkit::twins::{BasicTwin, Choice, MidpointTwin, PssmTwin};

use crate::{Stage, air};

/// How far a rasteriser may move a triangle's corner to its own grid, in texels: Vulkan asks for a
/// grid of a 16th at the least, and most have a 256th, which rounding and division make about this.
const SNAP: f64 = 1.0 / 128.0;

/// A pixel, as the oracle sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pixel {
    /// Nothing.
    Background,
    /// A point whose shadow term lies between these: they differ where a texel's middle is so near to
    /// a caster's edge that a rasteriser may draw it or not.
    Term(f64, f64),
    /// A point so near to an edge of a triangle, or of a hole, that a rasteriser may see another.
    Edge,
}

/// The stage's triangles and its light's plan.
pub struct Oracle<'a> {
    pub(crate) stage: &'a Stage,
    pub(crate) view: View,
    triangles: Vec<Triangle>,
    plan: ShadowPlan,
    twin: Option<Twin>,
    /// Whether bounds are read before the maps.
    bounded: bool,
    /// Depths that maps hold, where it is not the nearest depth.
    midpoint: Option<MidpointTwin>,
    /// The least and greatest depth of the map's texels that were sampled.
    texels: RefCell<HashMap<Texel, (f32, f32)>>,
}

/// Twin of the light's method, which samples its maps.
enum Twin {
    Basic(BasicTwin),
    Pssm(PssmTwin),
}

/// A texel's layer (of a method with several passes into one, the pass), column and row.
type Texel = (u32, u32, u32);

struct Triangle {
    corners: [DVec3; 3],
    uvs: [Vec2; 3],
    object: usize,
    /// Its place in the object's mesh.
    number: usize,
    /// Unit: where its front looks.
    normal: DVec3,
}

/// Faces that a ray may hit.
#[derive(Clone, Copy, PartialEq)]
enum Side {
    Either,
    Front,
    Back,
}

pub(crate) struct Hit {
    distance: f64,
    triangle: usize,
    /// How near the hit is to the triangle's edge or a hole's, as a share of the triangle.
    margin: f64,
}

impl<'a> Oracle<'a> {
    /// An oracle for a picture of `width` × `height` pixels. None where the light has a method other
    /// than `basic` and `pssm`.
    pub fn new(stage: &'a Stage, registry: &Registry, width: u32, height: u32) -> Option<Self> {
        let scene = &stage.scene;
        let mut triangles = Vec::new();
        for (object, instance) in scene.objects.iter().enumerate() {
            let mesh = &instance.mesh;
            for (number, indices) in mesh.indices.chunks_exact(3).enumerate() {
                let corner = |i: usize| {
                    instance
                        .transform
                        .transform_point3(mesh.positions[indices[i] as usize].as_dvec3())
                };
                let uv = |i: usize| mesh.uvs[indices[i] as usize];
                let [a, b, c] = [corner(0), corner(1), corner(2)];
                // A mirror turns the winding, and not the front.
                let turned = instance.transform.matrix3.determinant().signum();
                triangles.push(Triangle {
                    corners: [a, b, c],
                    normal: turned * (b - a).cross(c - a).normalize(),
                    uvs: [uv(0), uv(1), uv(2)],
                    object,
                    number,
                });
            }
        }
        let view = scene.view(width, height);
        let light = &scene.lights.first()?;
        let shadow = light.shadow.as_ref();
        let filter = shadow.and_then(|shadow| shadow.axes.get("filter"));
        let bounded = filter.is_some_and(|filter| filter != "pcf" && !filter.starts_with("esm"));
        let (plan, twin, midpoint) = match &light.shadow {
            None => (ShadowPlan::default(), None, None),
            Some(shadow) => {
                let axes: BTreeMap<_, _> = shadow.axes.clone();
                let value = |axis: &str| axes.get(axis).map(String::as_str);
                let choice = registry.choose(&shadow.method, value).ok()?;
                let chosen = shadow
                    .settings
                    .iter()
                    .map(|(name, value)| (name.as_str(), *value));
                let settings = Settings::check(&choice.settings(), chosen).ok()?;
                let bounds: Vec<_> = scene.objects.iter().map(|object| object.bounds).collect();
                let frustum = view.frustum();
                let receivers: Vec<_> = bounds
                    .iter()
                    .copied()
                    .filter(|bounds| frustum.intersects(bounds) && light.light.reaches(bounds))
                    .collect();
                let plan = choice
                    .method
                    .plan(&Frame {
                        view: &view,
                        light: &light.light,
                        casters: Casters {
                            casters: &bounds,
                            receivers: &receivers,
                            air: air::shaded(scene, &view, &light.light),
                        },
                        settings: &settings,
                        axes: &axes,
                        depth: choice.depth.as_deref(),
                        filter: choice.filter.as_deref(),
                        camera_depth: None,
                        answers: Answers::none(),
                    })
                    .ok()?;
                let width = axes.get("pcf")?.parse().ok()?;
                let plane = axes.get("receiver_bias")? == "plane";
                let twin = if shadow.method == "pssm" {
                    let choice = Choice {
                        lookup: axes.get("lookup")?.clone(),
                        taper: axes.get("taper")? == "on",
                        transition: axes.get("transition")?.clone(),
                        depth: axes.get("depth")?.clone(),
                        band: settings.get("band"),
                    };
                    Twin::Pssm(PssmTwin::new(&plan, width, plane, choice)?)
                } else {
                    Twin::Basic(BasicTwin::new(&plan, width, plane)?)
                };
                let midpoint = axes
                    .get("depth")?
                    .starts_with("midpoint")
                    .then_some(MidpointTwin {
                        // Means of exponentials need none in maps as large as these.
                        depth_bias: match filter.is_some_and(|filter| filter.starts_with("esm")) {
                            true => 0.0,
                            false => settings.get("depth_bias"),
                        },
                        width,
                        receiver_plane: plane,
                    });
                (plan, Some(twin), midpoint)
            }
        };
        Some(Self {
            stage,
            view,
            triangles,
            plan,
            twin,
            bounded,
            midpoint,
            texels: RefCell::default(),
        })
    }

    /// The pixel in column `x` and row `y` of `width` × `height`, as the oracle sees it.
    pub fn pixel(&self, x: u32, y: u32, width: u32, height: u32) -> Pixel {
        let (position, normal) = match self.receiver(x, y, width, height) {
            Ok(receiver) => receiver,
            Err(none) => return none,
        };
        let [dark, lit] = self.term(position, normal);
        Pixel::Term(dark, lit)
    }

    /// The least and the greatest shadow term at a point on a plane with this normal, zero where it is unknown.
    pub(crate) fn term(&self, position: DVec3, normal: DVec3) -> [f64; 2] {
        match &self.twin {
            None => [1.0; 2],
            Some(Twin::Basic(twin)) => {
                let term = |pick: fn((f32, f32)) -> f32| {
                    let texel = |layer, x, y| pick(self.texel(layer, x, y));
                    twin.calc_shadow(position, normal, texel)
                };
                [term(|range| range.1), term(|range| range.0)]
            }
            Some(Twin::Pssm(twin)) => {
                let term = |pick: fn((f32, f32)) -> f32| {
                    let texel = |pass: usize, x, y| pick(self.texel(pass as u32, x, y));
                    twin.calc_shadow(position, normal, texel)
                };
                [term(|range| range.1)[0], term(|range| range.0)[1]]
            }
        }
    }

    /// Where the pixel sees a surface (metres, relative to the camera), and the surface's unit normal on
    /// the viewer's side.
    ///
    /// # Errors
    /// Things that it sees where that is no surface for sure.
    pub fn receiver(
        &self,
        x: u32,
        y: u32,
        width: u32,
        height: u32,
    ) -> Result<(DVec3, DVec3), Pixel> {
        let (hit, position) = self.see(x, y, width, height)?;
        let [a, b, c] = self.triangles[hit.triangle].corners;
        let normal = (b - a).cross(c - a).normalize();
        let away = normal.dot(self.view.sight(position)) > 0.0;
        Ok((position, if away { -normal } else { normal }))
    }

    /// The object and the triangle in its mesh that the pixel sees.
    ///
    /// # Errors
    /// Things that it sees where that is no triangle for sure.
    pub fn triangle(
        &self,
        x: u32,
        y: u32,
        width: u32,
        height: u32,
    ) -> Result<(usize, usize), Pixel> {
        let (hit, _) = self.see(x, y, width, height)?;
        let triangle = &self.triangles[hit.triangle];
        Ok((triangle.object, triangle.number))
    }

    /// The least and the most texture fetches that the shadow term of the pixel takes: none where it reads no map, and
    /// where it does, all that the plan promises; one at the least where what is read first may tell.
    ///
    /// # Errors
    /// Things that the pixel sees where that is no surface for sure.
    pub fn fetches(&self, x: u32, y: u32, width: u32, height: u32) -> Result<[u32; 2], Pixel> {
        Ok(self.range_of(self.most_fetches(x, y, width, height)?))
    }

    /// The least and the most fetches of a point's term that takes so many where no bounds save any.
    pub(crate) fn range_of(&self, fetches: u32) -> [u32; 2] {
        match self.bounded {
            true => [fetches.min(1), fetches.min(1) * self.plan.fetches_per_pixel],
            false => [fetches; 2],
        }
    }

    fn most_fetches(&self, x: u32, y: u32, width: u32, height: u32) -> Result<u32, Pixel> {
        let (position, normal) = self.receiver(x, y, width, height)?;
        let [least, most] = self.fetches_at(position, normal);
        if least == most {
            Ok(least)
        } else {
            Err(Pixel::Edge)
        }
    }

    /// The least and the most texture fetches that the shadow term of a point takes.
    pub(crate) fn fetches_at(&self, position: DVec3, normal: DVec3) -> [u32; 2] {
        let twin = match &self.twin {
            None => return [0; 2],
            Some(Twin::Pssm(twin)) => return twin.fetches(position),
            Some(Twin::Basic(twin)) => twin,
        };
        let reads = Cell::new(false);
        twin.calc_shadow(position, normal, |_, _, _| {
            reads.set(true);
            0.0
        });
        let fetches = if reads.get() {
            self.plan.fetches_per_pixel
        } else {
            0
        };
        [fetches; 2]
    }

    /// The least and the greatest depth that the first map holds where the pixel's surface falls into
    /// it: what a caster's pass wrote there, or 0 where it wrote nothing.
    pub fn stored(&self, x: u32, y: u32, width: u32, height: u32) -> Pixel {
        // Less than this a device is off when it looks for the texel, in texels.
        const ROUNDING: f64 = 1e-3;
        let position = match self.receiver(x, y, width, height) {
            Ok((position, _)) => position,
            Err(none) => return none,
        };
        let Some(Pass::Casters(pass)) = self.plan.passes.first() else {
            return Pixel::Background;
        };
        let ndc = pass.view_proj.as_dmat4().project_point3(position);
        let size = f64::from(pass.viewport.width);
        let place = DVec2::new(0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y) * size;
        let around = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)].map(|(x, y)| {
            let texel = (place + DVec2::new(x, y) * ROUNDING).as_uvec2();
            self.texel(0, texel.x, texel.y)
        });
        let dark = around.iter().map(|range| range.0).fold(1.0, f32::min);
        let lit = around.iter().map(|range| range.1).fold(0.0, f32::max);
        Pixel::Term(dark.into(), lit.into())
    }

    /// Hit of the ray through the pixel, and where it is (metres, relative to the camera).
    pub(crate) fn see(
        &self,
        x: u32,
        y: u32,
        width: u32,
        height: u32,
    ) -> Result<(Hit, DVec3), Pixel> {
        let at = |value: u32, of: u32| (f64::from(value) + 0.5) / f64::from(of);
        let ndc = DVec2::new(2.0 * at(x, width) - 1.0, 1.0 - 2.0 * at(y, height));
        let (start, direction) = ray(self.view.view_proj_relative(), ndc);
        let hit = self.cast(self.view.position + start, direction, Side::Either);
        let hit = hit.ok_or(Pixel::Background)?;
        if hit.margin < 0.02 {
            return Err(Pixel::Edge);
        }
        let position = start + direction * hit.distance;
        Ok((hit, position))
    }

    /// The least and the greatest depth that a texel of the shadow map may hold.
    fn texel(&self, layer: u32, x: u32, y: u32) -> (f32, f32) {
        if let Some(known) = self.texels.borrow().get(&(layer, x, y)) {
            return *known;
        }
        let places = [
            (0.0, 0.0),
            (1.0, 1.0),
            (-1.0, 1.0),
            (1.0, -1.0),
            (-1.0, -1.0),
        ];
        let depths = places.map(|(across, down)| {
            let place = DVec2::new(f64::from(x), f64::from(y)) + 0.5;
            self.depth(layer, place + DVec2::new(across, down) * SNAP)
        });
        let range = (
            depths.into_iter().fold(1.0, f32::min),
            depths.into_iter().fold(0.0, f32::max),
        );
        self.texels.borrow_mut().insert((layer, x, y), range);
        range
    }

    /// The depth at a place in the shadow map, in texels.
    fn depth(&self, layer: u32, place: DVec2) -> f32 {
        let mut passes = self.plan.passes.iter().enumerate();
        let pass = passes.find_map(|(number, pass)| match (pass, &self.twin) {
            (Pass::Casters(pass), Some(Twin::Pssm(_))) => {
                (number == layer as usize).then_some(pass)
            }
            (Pass::Casters(pass), _) => {
                let own = pass.depth.as_ref().map_or(0, |depth| depth.target.layer);
                (own == layer).then_some(pass)
            }
            _ => None,
        });
        // A layer that nothing is drawn into holds what it is cleared to: far.
        let Some(pass) = pass else { return 0.0 };
        let at = place / f64::from(pass.viewport.width);
        let matrix = pass.view_proj.as_dmat4();
        let ndc = DVec2::new(2.0 * at.x - 1.0, 1.0 - 2.0 * at.y);
        let (start, direction) = ray(matrix, ndc);
        let nearest = |side| {
            let hit = self.cast(self.view.position + start, direction, side);
            let depth = hit.map(|hit| matrix.project_point3(start + direction * hit.distance).z);
            depth
                .filter(|depth| (0.0..=1.0).contains(depth))
                .unwrap_or(0.0)
        };
        let depth = match self.midpoint {
            None => nearest(Side::Either),
            Some(midpoint) => midpoint.depth(nearest(Side::Front), nearest(Side::Back), |depth| {
                texel_width(matrix, ndc.extend(depth), pass.viewport.width)
            }),
        };
        depth as f32
    }

    /// The first solid hit on the ray's way.
    fn cast(&self, start: DVec3, direction: DVec3, side: Side) -> Option<Hit> {
        let mut nearest: Option<Hit> = None;
        for (index, triangle) in self.triangles.iter().enumerate() {
            let seen = match triangle.normal.dot(direction) < 0.0 {
                true => Side::Front,
                false => Side::Back,
            };
            if side != Side::Either && side != seen {
                continue;
            }
            let [a, b, c] = triangle.corners;
            // Möller and Trumbore 1997.
            let (ab, ac) = (b - a, c - a);
            let across = direction.cross(ac);
            let volume = ab.dot(across);
            let offset = (start - a) / volume;
            let u = offset.dot(across);
            let turned = offset.cross(ab);
            let (v, distance) = (direction.dot(turned), ac.dot(turned));
            let inside = u >= 0.0 && v >= 0.0 && u + v <= 1.0 && distance > 0.0;
            if !inside || nearest.as_ref().is_some_and(|hit| hit.distance <= distance) {
                continue;
            }
            let [ta, tb, tc] = triangle.uvs;
            let uv = ta * (1.0 - u - v) as f32 + tb * u as f32 + tc * v as f32;
            let mut margin = u.min(v).min(1.0 - u - v);
            if triangle.object == self.stage.screen {
                let step = Vec2::splat(0.01);
                let around = [
                    uv + step,
                    uv - step,
                    uv + step * Vec2::new(1.0, -1.0),
                    uv - step * Vec2::new(1.0, -1.0),
                ];
                let solid = (self.stage.solid)(uv.clamp(Vec2::ZERO, Vec2::splat(0.999)));
                if around.iter().any(|near| {
                    (self.stage.solid)(near.clamp(Vec2::ZERO, Vec2::splat(0.999))) != solid
                }) {
                    margin = 0.0;
                }
                if !solid {
                    continue;
                }
            }
            nearest = Some(Hit {
                distance,
                triangle: index,
                margin,
            });
        }
        nearest
    }
}

/// How much the depth differs over the longer side of a texel at `ndc` of a map `size` texels along, laid along
/// the light's axis.
fn texel_width(matrix: DMat4, ndc: DVec3, size: u32) -> f64 {
    // Of a whole.
    const SMALL: f64 = 1e-6;
    let inverse = matrix.inverse();
    let middle = inverse.project_point3(ndc);
    let step = |by: DVec3| inverse.project_point3(ndc + by) - middle;
    let texel = 2.0 / f64::from(size);
    let (across, down) = (step(DVec3::X * texel), step(DVec3::Y * texel));
    let axis = across.cross(down).normalize();
    let deep = step(DVec3::Z * SMALL).dot(axis).abs() / SMALL;
    across.length().max(down.length()) / deep
}

/// The ray through `ndc`: where it starts (depth 1, the near plane) and its unit direction, in the
/// space that `matrix` takes to clip space.
pub(crate) fn ray(matrix: DMat4, ndc: DVec2) -> (DVec3, DVec3) {
    let inverse = matrix.inverse();
    let near = inverse.project_point3(ndc.extend(1.0));
    // Depth 0 may be infinitely far; halfway in depth is somewhere beyond the near plane.
    let beyond = inverse.project_point3(ndc.extend(0.5));
    (near, (beyond - near).normalize())
}

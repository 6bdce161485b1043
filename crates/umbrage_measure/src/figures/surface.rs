//! Surfaces that a picture sees, as planes, and how planes and pictures relate.

use glam::{DAffine3, DMat2, DMat3, DMat4, DVec2, DVec3, Vec3};
use rayon::prelude::*;
use umbrage_render::Scene;

use umbrage_shadow::{Light, View};

use super::FigureError;
use crate::truth::{Seen, Sight, lamp::Lamp};

/// Points that the pixels see, with their triangles' planes.
pub(super) struct Surface {
    pub(super) width: usize,
    pub(super) height: usize,
    /// By rows from the top.
    pub(super) facets: Vec<Option<Facet>>,
    /// The picture.
    pub(super) picture: Cells,
    /// The view that it is drawn from: positions are relative to it.
    pub(super) view: View,
}

/// The plane of the triangle that a pixel sees.
#[derive(Clone, Copy, Debug)]
pub(super) struct Facet {
    pub(super) object: u32,
    /// Metres, world axes, relative to the view.
    pub(super) position: DVec3,
    /// Unit, towards the viewer.
    pub(super) to_viewer: DVec3,
    /// Unit, on the viewer's side.
    pub(super) normal: DVec3,
    /// The normal that light is reflected by, on the same side: between those of the triangle's corners.
    pub(super) shading: DVec3,
    /// How wide the pixel is there, across the line of sight; metres.
    pub(super) pixel: f64,
}

/// A rectangle of cells (pixels, or a map's texels) that camera-relative positions project to.
#[derive(Clone, Debug)]
pub(super) struct Cells {
    clip: DMat4,
    size: DVec2,
}

impl Surface {
    pub(super) fn new(scene: &Scene, sight: &Sight) -> Result<Self, FigureError> {
        let view = scene.view(sight.width(), sight.height());
        view.validate().map_err(FigureError::Camera)?;
        let size = DVec2::new(f64::from(sight.width()), f64::from(sight.height()));
        let picture = Cells::new(view.view_proj_relative(), size);
        let facet = |seen: &Option<Seen>| {
            let facet = |seen: &Seen| Facet::new(scene, seen, &view, &picture);
            seen.as_ref().map(facet).transpose()
        };
        Ok(Self {
            width: sight.width() as usize,
            height: sight.height() as usize,
            facets: sight
                .seen()
                .par_iter()
                .map(facet)
                .collect::<Result<_, _>>()?,
            picture,
            view,
        })
    }

    /// Whether what is seen is turned away from the light, so that none of it reaches the eye: as its shader has it, by the normal
    /// between those of the triangle's corners.
    pub(super) fn back_facing(&self, light: &Light) -> Vec<bool> {
        let lamp = Lamp::new(&light.kind, self.view.position);
        let away = |facet: &Facet| facet.shading.dot(lamp.middle(facet.position).direction) <= 0.0;
        let facets = self.facets.iter();
        facets
            .map(|facet| facet.as_ref().is_some_and(away))
            .collect()
    }

    /// A pixel's column and row.
    pub(super) fn column_row(&self, pixel: usize) -> [usize; 2] {
        [pixel % self.width, pixel / self.width]
    }

    /// The pixels left and right of a pixel, above and below it.
    pub(super) fn around(&self, pixel: usize) -> impl Iterator<Item = usize> + use<> {
        let [x, y] = self.column_row(pixel);
        let left = (x > 0).then(|| pixel - 1);
        let right = (x + 1 < self.width).then(|| pixel + 1);
        let above = (y > 0).then(|| pixel - self.width);
        let below = (y + 1 < self.height).then(|| pixel + self.width);
        [left, right, above, below].into_iter().flatten()
    }

    /// Whether two pixels see the same surface without a jump in between.
    pub(super) fn is_one(&self, a: usize, b: usize) -> bool {
        match (&self.facets[a], &self.facets[b]) {
            (Some(a), Some(b)) => a.continues(b),
            _ => false,
        }
    }
}

impl Facet {
    fn new(scene: &Scene, seen: &Seen, view: &View, picture: &Cells) -> Result<Self, FigureError> {
        let position = seen.position + (scene.camera.position - view.position);
        let to_viewer = -view.sight(position);
        let triangle = Triangle::of(scene, seen).ok_or(FigureError::ForeignSight {
            object: seen.object,
            triangle: seen.triangle,
        })?;
        let towards = |normal: DVec3, side: DVec3| match normal.dot(side) < 0.0 {
            true => -normal,
            false => normal,
        };
        let normal = towards(triangle.normal(to_viewer), to_viewer);
        let shading = triangle.shading(scene.camera.position + seen.position);
        Ok(Self {
            object: seen.object,
            position,
            to_viewer,
            normal,
            shading: towards(shading.unwrap_or(normal), normal),
            pixel: picture.across(position, to_viewer).width(),
        })
    }

    /// Whether another facet goes on where this one ends: it is of the same object, and each point lies
    /// within a pixel's width of the other's plane. At a silhouette one of them does not, whichever
    /// of the two surfaces is the nearer one.
    pub(super) fn continues(&self, other: &Self) -> bool {
        let offset = other.position - self.position;
        let aside = offset
            .dot(self.normal)
            .abs()
            .max(offset.dot(other.normal).abs());
        self.object == other.object && aside <= self.pixel.max(other.pixel)
    }
}

/// A triangle that is seen, as its object's mesh has it.
struct Triangle<'a> {
    transform: &'a DAffine3,
    corners: [DVec3; 3],
    normals: [DVec3; 3],
}

impl<'a> Triangle<'a> {
    /// None where the scene has no such triangle.
    fn of(scene: &'a Scene, seen: &Seen) -> Option<Self> {
        let object = scene.objects.get(seen.object as usize)?;
        let first = 3 * seen.triangle as usize;
        let vertices = object.mesh.indices.get(first..first + 3)?;
        let of = |values: &[Vec3]| {
            let mut all = [DVec3::ZERO; 3];
            for (value, vertex) in all.iter_mut().zip(vertices) {
                *value = values.get(*vertex as usize)?.as_dvec3();
            }
            Some(all)
        };
        Some(Self {
            transform: &object.transform,
            corners: of(&object.mesh.positions)?,
            // A mesh without normals is shaded flat.
            normals: of(&object.mesh.normals).unwrap_or_default(),
        })
    }

    /// The unit normal of its plane, on either side; `to_viewer` where it is no plane.
    fn normal(&self, to_viewer: DVec3) -> DVec3 {
        // The translation plays no part, so nothing is lost far out. Edges are scaled, so that the product
        // of tiny ones does not vanish.
        let [a, b, c] = self.corners;
        let [ab, ac] = [b - a, c - a].map(|edge| {
            let edge = self.transform.matrix3 * edge;
            edge / edge.abs().max_element().max(f64::MIN_POSITIVE)
        });
        ab.cross(ac).normalize_or(to_viewer)
    }

    /// The unit normal between those of its corners `at` a point of it in the world, on either side; none where they come to nothing.
    fn shading(&self, at: DVec3) -> Option<DVec3> {
        let [a, b, c] = self
            .corners
            .map(|corner| self.transform.transform_point3(corner) - at);
        // Weights of the corners: the areas across from them.
        let whole = (b - a).cross(c - a);
        let weights = [b.cross(c), c.cross(a), a.cross(b)].map(|area| area.dot(whole));
        let normals = self.normals.into_iter().zip(weights);
        let between: DVec3 = normals.map(|(normal, weight)| normal * weight).sum();
        let DMat3 {
            x_axis,
            y_axis,
            z_axis,
        } = self.transform.matrix3;
        let cofactors = DMat3::from_cols(
            y_axis.cross(z_axis),
            z_axis.cross(x_axis),
            x_axis.cross(y_axis),
        );
        (cofactors * between).try_normalize()
    }
}

impl Cells {
    /// `clip` takes camera-relative positions (metres, world axes) to clip space.
    pub(super) fn new(clip: DMat4, size: DVec2) -> Self {
        Self { clip, size }
    }

    /// Where a point lies, in cells right and down from the upper left corner; none behind the
    /// projection's eye, or beside the rectangle.
    pub(super) fn place(&self, point: DVec3) -> Option<DVec2> {
        let at = self.clip * point.extend(1.0);
        let place = DVec2::new(at.w + at.x, at.w - at.y) / (2.0 * at.w) * self.size;
        let inside = place.cmpge(DVec2::ZERO).all() && place.cmple(self.size).all();
        (at.w > 0.0 && inside).then_some(place)
    }

    /// How the place of a point changes by metres along each of two directions; cells per metre.
    pub(super) fn derivative(&self, point: DVec3, directions: [DVec3; 2]) -> DMat2 {
        let at = self.clip * point.extend(1.0);
        let ndc = at.truncate().truncate() / at.w;
        let scale = DVec2::new(0.5, -0.5) * self.size / at.w;
        let [a, b] = directions.map(|direction| {
            let by = self.clip * direction.extend(0.0);
            scale * (by.truncate().truncate() - ndc * by.w)
        });
        DMat2::from_cols(a, b)
    }

    /// The cells at a point, as they lie across a ray of the unit direction `ray`.
    pub(super) fn across(&self, point: DVec3, ray: DVec3) -> Across {
        let (right, up) = ray.any_orthonormal_pair();
        Across {
            directions: [right, up],
            cells: self.derivative(point, [right, up]),
        }
    }
}

/// How cells lie across a ray.
#[derive(Clone, Copy, Debug)]
pub(super) struct Across {
    /// Unit, perpendicular to the ray and to each other.
    pub(super) directions: [DVec3; 2],
    /// Cells by metres along each.
    pub(super) cells: DMat2,
}

impl Across {
    /// The side of the square that is as large as a cell; metres.
    pub(super) fn width(&self) -> f64 {
        self.cells.determinant().abs().sqrt().recip()
    }
}

/// The largest singular value: by how much a matrix stretches what it stretches most.
pub(super) fn stretch(m: DMat2) -> f64 {
    let [a, b] = [m.x_axis, m.y_axis];
    0.5 * ((a.x + b.y).hypot(a.y - b.x) + (a.x - b.y).hypot(a.y + b.x))
}

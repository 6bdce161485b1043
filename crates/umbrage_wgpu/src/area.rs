//! Parts of maps that moved casters may have changed.

use std::{borrow::Cow, fmt::Write as _};

use glam::{DMat4, DVec2, DVec3, DVec4, Vec4Swizzles as _};
use umbrage_shadow::{Aabb, CasterPass, Viewport};

use crate::{ColorState, DrawState};

/// A rectangle of texels: left, top, and the first beyond, right and down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Area {
    pub(crate) from: [u32; 2],
    pub(crate) to: [u32; 2],
}

impl Area {
    /// No texel.
    pub(crate) const NOWHERE: Self = Self {
        from: [0; 2],
        to: [0; 2],
    };

    pub(crate) fn union(self, other: Self) -> Self {
        let pick = |pick: fn(u32, u32) -> u32, a: [u32; 2], b: [u32; 2]| {
            [pick(a[0], b[0]), pick(a[1], b[1])]
        };
        Self {
            from: pick(u32::min, self.from, other.from),
            to: pick(u32::max, self.to, other.to),
        }
    }

    pub(crate) fn meets(self, other: Self) -> bool {
        (0..2).all(|i| self.from[i] < other.to[i] && other.from[i] < self.to[i])
    }

    /// The whole of a viewport.
    pub(crate) fn of(viewport: &Viewport) -> Self {
        Self {
            from: [viewport.x, viewport.y],
            to: [
                viewport.x.saturating_add(viewport.width),
                viewport.y.saturating_add(viewport.height),
            ],
        }
    }
}

/// Where in its viewport a pass draws what lies in a box.
pub(crate) struct Shadower {
    viewport: Area,
    matrix: DMat4,
    origin: DVec3,
    /// Whether clip space is the world's but for an affine map.
    affine: bool,
    /// Rows of absolute values, for bounds.
    reach: [DVec4; 3],
}

/// Texels that a rasteriser's grid and its rule of filling may add.
const GRID: f64 = 1.0;

impl Shadower {
    /// For a pass whose positions are relative to `origin`.
    pub(crate) fn new(pass: &CasterPass, origin: DVec3) -> Self {
        let matrix = pass.view_proj.as_dmat4();
        let rows = matrix.transpose();
        Self {
            viewport: Area::of(&pass.viewport),
            affine: rows.w_axis == DVec4::W,
            reach: [rows.x_axis, rows.y_axis, rows.w_axis].map(DVec4::abs),
            matrix,
            origin,
        }
    }

    /// The texels that may be drawn for a caster in a box, and none others; none where it lies beside the viewport.
    pub(crate) fn area(&self, aabb: &Aabb) -> Option<Area> {
        let (center, half) = (
            (aabb.min + aabb.max) / 2.0 - self.origin,
            (aabb.max - aabb.min) / 2.0,
        );
        // Vertices go to the world and to clip space in 32 bits: four products and sums each.
        let most = (center.abs() + half).extend(1.0);
        let rounding = self
            .reach
            .map(|row| 8.0 * f64::from(f32::EPSILON) * row.dot(most));
        let (least, most) = match self.affine {
            true => {
                let middle = (self.matrix * center.extend(1.0)).xy();
                let reach = [self.reach[0], self.reach[1]].map(|row| row.truncate().dot(half));
                let reach = DVec2::new(reach[0] + rounding[0], reach[1] + rounding[1]);
                (middle - reach, middle + reach)
            }
            false => {
                let mut around: Option<(DVec2, DVec2)> = None;
                for corner in aabb.corners() {
                    let at = self.matrix * (corner - self.origin).extend(1.0);
                    let depth = at.w - rounding[2];
                    if depth <= 0.0 {
                        return Some(self.viewport);
                    }
                    let place = at.xy() / at.w;
                    let off = DVec2::new(rounding[0], rounding[1]) + place.abs() * rounding[2];
                    let (least, most) = around.unwrap_or((place, place));
                    let off = off / depth;
                    around = Some((least.min(place - off), most.max(place + off)));
                }
                around?
            }
        };
        let [width, height] =
            [0, 1].map(|i| f64::from(self.viewport.to[i] - self.viewport.from[i]));
        // Clip space is y up, texels are y down.
        let x = [least.x, most.x].map(|x| (x * 0.5 + 0.5) * width);
        let y = [most.y, least.y].map(|y| (0.5 - y * 0.5) * height);
        let span = |[start, end]: [f64; 2], extent: f64, first: u32| {
            let start = (start - GRID).floor().clamp(0.0, extent);
            let end = (end + GRID).ceil().clamp(0.0, extent);
            // A bound that is no number is everywhere.
            let [start, end] = if start <= end {
                [start, end]
            } else {
                [0.0, extent]
            };
            [first + start as u32, first + end as u32]
        };
        let x = span(x, width, self.viewport.from[0]);
        let y = span(y, height, self.viewport.from[1]);
        let area = Area {
            from: [x[0], y[0]],
            to: [x[1], y[1]],
        };
        (area.from[0] < area.to[0] && area.from[1] < area.to[1]).then_some(area)
    }
}

/// Values that an area is made empty with.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Empty {
    /// The state of what is drawn then.
    pub(crate) state: DrawState,
    /// Bits of the depth, where there is one.
    pub(crate) depth: Option<u32>,
    /// Bits of each colour's channels.
    pub(crate) colors: Vec<u32>,
}

impl Empty {
    /// The pipeline that fills what is drawn with these values: one triangle of three vertices without buffers.
    pub(crate) fn pipeline(&self, device: &wgpu::Device) -> wgpu::RenderPipeline {
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("empty"),
            source: wgpu::ShaderSource::Wgsl(Cow::Owned(self.shader())),
        });
        let target = |color: &ColorState| {
            Some(wgpu::ColorTargetState {
                format: color.format,
                blend: None,
                write_mask: wgpu::ColorWrites::ALL,
            })
        };
        let targets: Vec<_> = self.state.colors.iter().map(target).collect();
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("empty"),
            layout: None,
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("whole"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: self.state.depth.map(|format| wgpu::DepthStencilState {
                format,
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::Always),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("empty"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &targets,
            }),
            multiview_mask: None,
            cache: None,
        })
    }

    fn shader(&self) -> String {
        let mut text = String::from(
            "@vertex fn whole(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {\n\
             return vec4f(f32(i & 1) * 4.0 - 1.0, f32(i >> 1) * 4.0 - 1.0, 0.0, 1.0);\n}\n\
             struct Out {\n",
        );
        let mut values = Vec::new();
        // A fragment's own depth is kept to the last bit.
        if let Some(bits) = self.depth {
            text.push_str("@builtin(frag_depth) depth: f32,\n");
            values.push(format!("bitcast<f32>({bits}u)"));
        }
        for (location, bits) in self.colors.iter().enumerate() {
            // Writing to a string does not fail.
            let _ = writeln!(text, "@location({location}) color_{location}: vec4f,");
            values.push(format!("vec4f(bitcast<f32>({bits}u))"));
        }
        let values = values.join(", ");
        let _ = write!(
            text,
            "}}\n@fragment fn empty() -> Out {{\nreturn Out({values});\n}}\n"
        );
        text
    }
}

#[cfg(test)]
mod tests {
    use glam::Mat4;
    use proptest::prelude::*;
    use umbrage_shadow::{Constants, Cull};

    use super::*;

    fn pass(view_proj: DMat4) -> CasterPass {
        CasterPass {
            shader: "caster".to_owned(),
            depth: None,
            colors: Vec::new(),
            viewport: Viewport {
                x: 64,
                y: 32,
                width: 256,
                height: 128,
            },
            cull: Cull::Nothing,
            view_proj: Mat4::from_cols_array(&view_proj.to_cols_array().map(|x| x as f32)),
            constants: Constants::new(),
            casters: Vec::new(),
            receivers: None,
        }
    }

    proptest! {
        /// No point of a box is drawn outside the box's area, by the arithmetic of shaders.
        #[test]
        fn an_area_holds_its_box(
            center in prop::array::uniform3(-60.0..60.0_f64),
            half in prop::array::uniform3(0.0..8.0_f64),
            at in prop::array::uniform3(-1.0..1.0_f64),
            turn in prop::array::uniform3(-3.0..3.0_f64),
            perspective: bool,
        ) {
            let (center, half) = (DVec3::from(center), DVec3::from(half));
            let rotation = DMat4::from_euler(glam::EulerRot::XYZ, turn[0], turn[1], turn[2]);
            let project = match perspective {
                // Reversed depth, near plane at 0.3 m, none far.
                true => DMat4::from_cols_array_2d(&[
                    [0.8, 0.0, 0.0, 0.0],
                    [0.0, 1.6, 0.0, 0.0],
                    [0.0, 0.0, 0.0, -1.0],
                    [0.0, 0.0, 0.3, 0.0],
                ]),
                false => DMat4::from_scale(DVec3::new(0.02, 0.04, -0.01)),
            };
            let pass = pass(project * rotation);
            let origin = DVec3::new(1e4, -3.0, 5e3);
            let aabb = Aabb { min: origin + center - half, max: origin + center + half };
            let area = Shadower::new(&pass, origin).area(&aabb);
            let point = (center + half * DVec3::from(at)).as_vec3();
            let clip = pass.view_proj * point.extend(1.0);
            let [x, y] = [clip.x / clip.w, -clip.y / clip.w].map(|x| x * 0.5 + 0.5);
            if clip.w > 0.0 && (0.0..1.0).contains(&x) && (0.0..1.0).contains(&y) {
                let texel = [64.0 + x * 256.0, 32.0 + y * 128.0];
                let area = area.expect("something is seen");
                let spans = area.from.into_iter().zip(area.to).zip(texel);
                for ((from, to), texel) in spans {
                    prop_assert!(from as f32 <= texel && texel <= to as f32);
                }
            }
        }
    }
}

//! A frame under way: what is being rendered, and what its passes read.

use std::{
    collections::{BTreeMap, BTreeSet},
    sync::Arc,
};

use glam::{Mat4, Vec3};
use umbrage_compose::{Composed, Key, Permutation, Purpose};
use umbrage_shadow::Constants;
use umbrage_wgpu::{ColorState, DrawState, ShadowResources, Unfiltered};

use super::{
    RenderOptions,
    assets::Vertices,
    lights::{LightSetup, Term},
    objects::Objects,
    passes::NamedPass,
    target::DEPTH,
    timer::Timer,
};
use crate::{PermutationUse, Report};

/// The binding of what `linear_depth` lays down.
pub(super) const SEEN_PLANES: &str = "seen_planes";

/// Each pixel's plane: the unit normal and the linear depth, 0 where nothing is seen. In 16 bytes a
/// pixel, all floats: a normal in two halves is 1e-3 radians off, which at a slope of 19, light at 87°, moves a
/// receiver's plane by a third.
pub(super) const PLANE: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

/// The binding of the depth that the picture's passes leave.
pub(super) const SEEN_DEPTH: &str = "seen_depth";

/// A picture under way, and what has been found out about it.
pub(super) struct FrameState<'a> {
    pub(super) options: &'a RenderOptions,
    pub(super) objects: Objects<'a>,
    pub(super) encoder: wgpu::CommandEncoder,
    pub(super) report: Report,
    pub(super) timer: Timer,
    /// The lights whose shadow maps this frame uses, by their numbers.
    pub(super) shadow_maps: BTreeSet<u64>,
    /// Planes of what is seen, where they were laid down.
    pub(super) planes: Option<wgpu::TextureView>,
    /// The depth of what is seen, once it is there for the air.
    pub(super) seen_depth: Option<wgpu::TextureView>,
    /// The members of the shader's block `rays`.
    pub(super) rays: Constants,
    /// Whether the camera's rays are parallel.
    pub(super) orthographic: bool,
    /// By the full keys, so that each is asked for once.
    pub(super) composed: BTreeMap<Vec<Key>, Arc<Permutation>>,
}

/// Inputs that all draws of one pass share.
pub(super) struct PassInputs<'a> {
    pub(super) pass: NamedPass<'a>,
    /// The light on whose account it is drawn.
    pub(super) cause: Option<&'a str>,
    pub(super) view_proj: Mat4,
    pub(super) ambient: Vec3,
    /// The lights that the shader reads, in this order.
    pub(super) lights: Vec<LightInputs<'a>>,
    pub(super) vertices: Vertices,
    /// With `front` as it is for objects that are not mirrored.
    pub(super) state: DrawState,
}

/// The light that a pass is for.
#[derive(Clone, Copy)]
pub(super) struct LightInputs<'a> {
    pub(super) setup: &'a LightSetup<'a>,
    pub(super) constants: &'a Constants,
    pub(super) shadow: Option<&'a ShadowResources>,
    pub(super) term: Term<'a>,
}

/// A light as it is in a picture, with its shadow maps.
pub(super) struct Lamp<'a> {
    pub(super) setup: &'a LightSetup<'a>,
    pub(super) constants: Constants,
    pub(super) shadow: Option<Arc<ShadowResources>>,
}

impl Lamp<'_> {
    /// Inputs of a shader that finds the shadow term for itself.
    pub(super) fn reads(&self) -> LightInputs<'_> {
        LightInputs {
            setup: self.setup,
            constants: &self.constants,
            shadow: self.shadow.as_deref(),
            term: Term::Method,
        }
    }
}

impl<'a> FrameState<'a> {
    pub(super) fn new(
        options: &'a RenderOptions,
        objects: Objects<'a>,
        encoder: wgpu::CommandEncoder,
        timer: Timer,
        rays: Constants,
        orthographic: bool,
    ) -> Self {
        Self {
            planes: None,
            seen_depth: None,
            rays,
            orthographic,
            options,
            objects,
            encoder,
            report: Report::default(),
            timer,
            shadow_maps: BTreeSet::new(),
            composed: BTreeMap::new(),
        }
    }
}

impl FrameState<'_> {
    /// Reports a permutation that was needed: for an object (or what stands for one), and for a light where it was for one.
    pub(super) fn note(
        &mut self,
        composed: &Composed,
        purpose: Purpose,
        (object, light): (&str, Option<&str>),
    ) {
        let (key, others) = (&composed.permutation.key, &composed.permutation.others);
        let mut reported = self.report.permutations.iter();
        if reported.any(|used| used.key == *key && used.others == *others) {
            return;
        }
        self.report.warnings.extend(composed.warnings.clone());
        self.report.permutations.push(PermutationUse {
            key: key.clone(),
            others: others.clone(),
            purpose,
            source: composed.source,
            object: object.to_owned(),
            light: light.map(str::to_owned),
        });
    }
}

/// Resources of the lights that must not be filtered.
pub(super) fn unfiltered(lights: &[LightInputs<'_>]) -> Unfiltered {
    let none = ShadowResources::default();
    let shadows: Vec<_> = lights.iter().map(|l| l.shadow.unwrap_or(&none)).collect();
    umbrage_wgpu::unfiltered(&shadows)
}

/// Depth is only looked at.
pub(super) fn state(format: wgpu::TextureFormat, compare: wgpu::CompareFunction) -> DrawState {
    DrawState {
        colors: vec![ColorState {
            format,
            blend: None,
            channels: wgpu::ColorWrites::ALL,
        }],
        depth: Some(DEPTH),
        compare,
        write_depth: false,
        cull: None,
        front: wgpu::FrontFace::Ccw,
        unfiltered: Default::default(),
    }
}

//! Parts of a plan's textures and buffers that its passes read and write, checked and bound.

use std::collections::BTreeSet;

use umbrage_compose::{BindingKind, Permutation, TextureDimension};
use umbrage_shadow::{
    ComputePass, Pass, Reads, ShadowPlan, Slice, Source, TextureDesc, TextureShape, Workgroups,
};

use crate::{
    Error, ShadowResources,
    bind::Part,
    execute::Execution,
    record::{Place, Touches},
};

impl Execution<'_> {
    /// Places that a pass writes and reads, checked against what the plan has.
    pub(crate) fn touches(
        &self,
        pass: &Pass,
        permutation: Option<&Permutation>,
    ) -> Result<Touches, Error> {
        let mut touches = Touches::default();
        let stores = match pass {
            Pass::Casters(pass) => {
                let depth = pass.depth.iter().map(|depth| &depth.target);
                let colors = pass.colors.iter().map(|color| &color.target);
                for target in depth.chain(colors) {
                    self.sliced(target)?;
                    touches.writes.push(place(target));
                }
                &[][..]
            }
            Pass::Screen(pass) => {
                for target in &pass.targets {
                    self.sliced(target)?;
                    touches.writes.push(place(target));
                }
                &[][..]
            }
            Pass::Compute(pass) => {
                for written in &pass.writes {
                    touches.writes.extend(self.places(written, true)?);
                }
                touches.reads.extend(self.check_workgroups(pass)?);
                &pass.writes[..]
            }
            _ => return Err(self.bad("a pass of a kind that is not known here")),
        };
        let renamed = pass.reads().map_or(&[][..], |reads| &reads.renamed);
        let bindings = permutation.map(|permutation| &permutation.reflection.bindings);
        for binding in bindings.into_iter().flatten() {
            let source = source(renamed, &binding.name);
            self.check_room(&source, &binding.kind)?;
            match binding.kind {
                BindingKind::Texture { .. }
                | BindingKind::Storage {
                    read_only: true, ..
                } => touches.reads.extend(self.places(&source, false)?),
                BindingKind::StorageTexture { .. } | BindingKind::Storage { .. }
                    if !stores.contains(&source) =>
                {
                    let problem = format!(
                        "`{}` stores to `{}`, which is not among what it `writes`",
                        pass.shader(),
                        source.name
                    );
                    return Err(self.bad(&problem));
                }
                _ => {}
            }
        }
        let mut places = (1..).zip(&touches.writes);
        if let Some((_, place)) = places.find(|(next, w)| touches.writes[*next..].contains(w)) {
            let problem = format!("`{}` draws twice into {}", pass.shader(), self.words(place));
            return Err(self.bad(&problem));
        }
        let mut both = touches.writes.iter();
        if let Some(place) = both.find(|place| touches.reads.contains(*place)) {
            let problem = format!(
                "`{}` reads {}, which it writes",
                pass.shader(),
                self.words(place)
            );
            return Err(self.bad(&problem));
        }
        Ok(touches)
    }

    /// Whether a buffer that passes write has room for what a shader binds it as.
    fn check_room(&self, source: &Source, kind: &BindingKind) -> Result<(), Error> {
        let (BindingKind::Storage { layout, .. }, Some(buffer)) =
            (kind, self.resources.written.get(&source.name))
        else {
            return Ok(());
        };
        let (size, needed) = (buffer.size(), u64::from(layout.size));
        if size >= needed {
            return Ok(());
        }
        let problem = format!(
            "the buffer `{}` of {size} bytes, where a shader needs {needed} at the least",
            source.name
        );
        Err(self.bad(&problem))
    }

    /// How many workgroups a pass runs, checked; the buffer that they are read from.
    fn check_workgroups(&self, pass: &ComputePass) -> Result<Option<Place>, Error> {
        let (buffer, offset) = match &pass.workgroups {
            Workgroups::Count(count) => {
                let limits = self.shared.device.limits();
                let limit = limits.max_compute_workgroups_per_dimension;
                if count.iter().all(|n| (1..=limit).contains(n)) {
                    return Ok(None);
                }
                let problem = format!(
                    "{count:?} workgroups of `{}`, where the device allows from 1 to {limit} each way",
                    pass.shader
                );
                return Err(self.bad(&problem));
            }
            Workgroups::Indirect { buffer, offset } => (buffer, *offset),
        };
        let size = self.resources.written.get(buffer).map(wgpu::Buffer::size);
        let problem = match size {
            None => "which is no buffer that its passes write".to_owned(),
            Some(size)
                if offset % 4 != 0 || offset.checked_add(12).is_none_or(|end| end > size) =>
            {
                format!("of {size} bytes, which has no three words from byte {offset} on")
            }
            Some(_) => return Ok(Some((buffer.clone(), 0, 0))),
        };
        let problem = format!(
            "workgroups of `{}` by the buffer `{buffer}`, {problem}",
            pass.shader
        );
        Err(self.bad(&problem))
    }

    /// The places that a binding reads or writes; none where no pass fills what it reads.
    fn places(&self, source: &Source, writes: bool) -> Result<Vec<Place>, Error> {
        let name = &source.name;
        if self.resources.written.contains_key(name) {
            return Ok(vec![(name.clone(), 0, 0)]);
        }
        let Some((desc, _)) = self.texture(name) else {
            if !writes {
                return Ok(Vec::new());
            }
            let problem =
                format!("the target `{name}`, which is none of its textures and written buffers");
            return Err(self.bad(&problem));
        };
        let (layers, levels) = (desc.shape.layers(), desc.levels);
        if source.layer.is_some_and(|n| n >= layers) || source.level.is_some_and(|n| n >= levels) {
            let problem = format!(
                "what reads or writes {source:?}, which has {layers} layers and {levels} levels"
            );
            return Err(self.bad(&problem));
        }
        let one = |n: u32| n..n + 1;
        let layers = source.layer.map_or(0..layers, one);
        let levels = match source.level {
            None if writes => 0..1,
            level => level.map_or(0..levels, one),
        };
        let places = layers.flat_map(|layer| levels.clone().map(move |level| (layer, level)));
        Ok(places
            .map(|(layer, level)| (name.clone(), layer, level))
            .collect())
    }

    /// Whether all that a pass reads is filled before it.
    pub(crate) fn check_reads<'a>(
        &self,
        plan: &ShadowPlan,
        passes: impl Iterator<Item = &'a Touches>,
    ) -> Result<(), Error> {
        let uploaded = plan.contents.iter();
        let uploaded = uploaded.map(|contents| (contents.texture.clone(), 0, 0));
        let mut filled: BTreeSet<Place> = uploaded.collect();
        for (pass, touches) in plan.passes.iter().zip(passes) {
            let mut reads = touches.reads.iter();
            if let Some(place) = reads.find(|place| !filled.contains(*place)) {
                let problem = format!(
                    "`{}` reads {}, which has no contents and no pass before writes",
                    pass.shader(),
                    self.words(place)
                );
                return Err(self.bad(&problem));
            }
            filled.extend(touches.writes.iter().cloned());
        }
        Ok(())
    }

    /// A place as errors call it.
    fn words(&self, (name, layer, level): &Place) -> String {
        match self.texture(name) {
            Some((desc, _)) if desc.levels > 1 || desc.shape != TextureShape::D2 => {
                format!("level {level} of layer {layer} of `{name}`")
            }
            _ => format!("`{name}`"),
        }
    }

    /// Resources of a pass whose shader is `permutation`.
    pub(crate) fn given_to(
        &mut self,
        reads: &Reads,
        permutation: &Permutation,
    ) -> Result<ShadowResources, Error> {
        let mut given = self.resources.clone();
        given.constants = reads.constants.clone();
        for binding in &permutation.reflection.bindings {
            let (to, source) = (binding.name.clone(), source(&reads.renamed, &binding.name));
            let depth = self.job.camera_depth;
            if let Some(depth) = depth.filter(|_| source.name == Reads::CAMERA_DEPTH) {
                let format = depth.view.texture().format();
                given.textures.insert(to, (format, depth.view.clone()));
            } else if let Some(buffer) = self.resources.written.get(&source.name) {
                given.written.insert(to, buffer.clone());
            } else if let Some(value) = self.resources.buffers.get(&source.name) {
                given.buffers.insert(to, value.clone());
            } else if let Some((desc, texture)) = self.texture(&source.name).cloned() {
                let (dimension, stored) = match binding.kind {
                    BindingKind::Texture { dimension, .. } => (dimension, false),
                    BindingKind::StorageTexture { dimension, .. } => (dimension, true),
                    _ => continue,
                };
                let view = self.view((&desc, &texture), &source, (dimension, stored))?;
                given.textures.insert(to, (desc.format, view));
            }
        }
        Ok(given)
    }

    /// A view of a texture of this shape, as a shader binds it.
    fn view(
        &mut self,
        (desc, texture): (&TextureDesc, &wgpu::Texture),
        source: &Source,
        (dimension, stored): (TextureDimension, bool),
    ) -> Result<wgpu::TextureView, Error> {
        let layers = desc.shape.layers();
        let (dimension, first, count) = match (dimension, source.layer) {
            (TextureDimension::D2, None) if layers == 1 => (wgpu::TextureViewDimension::D2, 0, 1),
            (TextureDimension::D2, Some(layer)) => (wgpu::TextureViewDimension::D2, layer, 1),
            (TextureDimension::D2Array, layer) => {
                let (first, count) = layer.map_or((0, layers), |layer| (layer, 1));
                (wgpu::TextureViewDimension::D2Array, first, count)
            }
            (TextureDimension::Cube, None) if desc.shape == TextureShape::Cube => {
                (wgpu::TextureViewDimension::Cube, 0, layers)
            }
            (dimension, layer) => {
                let problem = format!(
                    "the texture `{}` of {layers} layers where a shader reads one of shape {dimension:?}, layer {layer:?}",
                    desc.name
                );
                return Err(self.bad(&problem));
            }
        };
        let levels = (stored || source.level.is_some()).then_some(1);
        let part = Part {
            dimension,
            layers: [first, count],
            level: (source.level.unwrap_or(0), levels),
        };
        Ok(self.shared.binder.view(texture, part))
    }
}

/// Whether a pass with this shader reads the camera's depth.
pub(crate) fn reads_camera_depth(pass: &Pass, permutation: &Permutation) -> bool {
    let renamed = pass.reads().map_or(&[][..], |reads| &reads.renamed);
    let mut bindings = permutation.reflection.bindings.iter();
    bindings.any(|binding| source(renamed, &binding.name).name == Reads::CAMERA_DEPTH)
}

/// The buffer or the part of a texture that a pass has for a binding.
pub(crate) fn source(renamed: &[(String, Source)], binding: &str) -> Source {
    let found = renamed.iter().find(|(from, _)| from == binding);
    found.map_or_else(|| binding.into(), |(_, source)| source.clone())
}

/// The place that a slice is.
pub(crate) fn place(target: &Slice) -> Place {
    (target.texture.clone(), target.layer, target.level)
}

//! Records of what stands in a plan's textures, so that nothing is drawn that stands already.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec3;
use umbrage_compose::ProjectedKey;
use umbrage_shadow::{BufferDesc, Constants, Pass, SamplerDesc, ShadowPlan};

use crate::{
    Identity,
    resources::{Buffers, Textures},
};

/// A layer of a texture, or layer 0 for a buffer.
pub(crate) type Layer = (String, u32);

/// All that a pass's outcome depends on, but for the textures and buffers that it reads.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Record {
    pub(crate) pass: Pass,
    /// The place that positions are relative to.
    pub(crate) origin: DVec3,
    /// The casters drawn, and the values that their shaders are chosen by.
    pub(crate) casters: Vec<Identity>,
    pub(crate) choices: Vec<(String, String)>,
    /// Of a pass without casters.
    pub(crate) shader: Option<Shader>,
}

/// A shader that draws no caster, and what it reads beside what passes fill.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Shader {
    pub(crate) key: ProjectedKey,
    pub(crate) light: Constants,
    pub(crate) samplers: Vec<SamplerDesc>,
    pub(crate) buffers: Vec<BufferDesc>,
    /// The revision of the camera's depth.
    pub(crate) camera_depth: Option<u64>,
}

/// The passes into each layer, in order.
pub(crate) type Layers = BTreeMap<Layer, Vec<Record>>;

/// All that was drawn for a light.
#[derive(Default)]
pub(crate) struct Memory {
    pub(crate) textures: Textures,
    /// Buffers that passes write.
    pub(crate) buffers: Buffers,
    /// The bytes that were uploaded.
    pub(crate) contents: BTreeMap<String, Vec<u8>>,
    pub(crate) drawn: Layers,
}

impl Memory {
    /// Lets go of what `plan` does not have, and of textures and buffers that were written and that it has no pass for: they
    /// hold what it does not expect.
    pub(crate) fn let_go(&mut self, plan: &ShadowPlan) {
        let written: BTreeSet<_> = plan.passes.iter().flat_map(layers).collect();
        let is_written = |name: &str| written.iter().any(|layer| layer.0 == name);
        let drawn = self.drawn.keys().map(|layer| &layer.0);
        let has = |name: &str| {
            let textures = plan.textures.iter().map(|desc| &desc.name);
            let buffers = plan.buffers.iter().map(|desc| &desc.name);
            textures.chain(buffers).any(|own| own == name)
        };
        let gone = drawn.filter(|name| !is_written(name) || !has(name));
        let gone: BTreeSet<_> = gone.cloned().collect();
        self.textures
            .retain(|name, _| has(name) && !gone.contains(name));
        self.buffers
            .retain(|name, _| has(name) && !gone.contains(name));
        self.drawn.retain(|layer, _| !gone.contains(&layer.0));
    }
}

/// The layers that a pass writes.
pub(crate) fn layers(pass: &Pass) -> Vec<Layer> {
    match pass {
        Pass::Casters(pass) => {
            let depth = pass.depth.as_ref();
            let depth = depth.map(|depth| (depth.texture.clone(), depth.layer));
            let color = pass.color.as_ref().map(|color| (color.texture.clone(), 0));
            depth.into_iter().chain(color).collect()
        }
        other => other.writes().map(|name| (name.to_owned(), 0)).collect(),
    }
}

/// The passes of each layer.
pub(crate) fn by_layer(records: &[Record]) -> Layers {
    let mut all = Layers::new();
    for record in records {
        for layer in layers(&record.pass) {
            all.entry(layer).or_default().push(record.clone());
        }
    }
    all
}

/// Which passes of `plan` have to be run, in its order. `reads` has the textures and buffers that each reads, `new` those that hold
/// nothing yet or were uploaded anew.
pub(crate) fn stale(
    plan: &ShadowPlan,
    (wanted, drawn): (&Layers, &Layers),
    reads: &[BTreeSet<String>],
    new: &BTreeSet<String>,
) -> Vec<bool> {
    let written: Vec<_> = plan.passes.iter().map(layers).collect();
    let mut stale: BTreeSet<&Layer> = wanted
        .iter()
        .filter(|(layer, records)| new.contains(&layer.0) || drawn.get(*layer) != Some(*records))
        .map(|(layer, _)| layer)
        .collect();
    let mut fresh: BTreeSet<&str> = new.iter().map(String::as_str).collect();
    fresh.extend(stale.iter().map(|layer| layer.0.as_str()));
    // What is filled again has what is made of it filled again, and all that one pass writes goes together. A texture that
    // later passes fill further has lost what a pass before them reads.
    loop {
        let before = (stale.len(), fresh.len());
        for (number, (layers, reads)) in written.iter().zip(reads).enumerate() {
            let runs = layers.iter().any(|layer| stale.contains(layer))
                || reads.iter().any(|name| fresh.contains(name.as_str()));
            if !runs {
                continue;
            }
            let lost = |layer: &&Layer| reads.contains(&layer.0);
            let lost = written[number + 1..].iter().flatten().filter(lost);
            let again: Vec<_> = layers.iter().chain(lost).collect();
            fresh.extend(again.iter().map(|layer| layer.0.as_str()));
            stale.extend(again);
        }
        if (stale.len(), fresh.len()) == before {
            break;
        }
    }
    let runs = |layers: &Vec<Layer>| layers.iter().any(|layer| stale.contains(layer));
    written.iter().map(runs).collect()
}

//! Records of what stands in a plan's textures, so that nothing is drawn that stands already.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec3;
use umbrage_compose::ProjectedKey;
use umbrage_shadow::{Aabb, BufferDesc, Constants, Pass, SamplerDesc, ShadowPlan};

use crate::{
    Identity,
    asked::Asked,
    resources::{Buffers, Textures},
};

/// A part that is filled as a whole: a layer and a mip level of a texture, or a buffer, as layer and level 0.
pub(crate) type Place = (String, u32, u32);

/// All that a pass's outcome depends on, but for the textures and buffers that it reads.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Record {
    pub(crate) pass: Pass,
    /// The place that positions are relative to.
    pub(crate) origin: DVec3,
    /// The casters drawn, with their bounds (one that moved is another, whatever its revision), and the values that their
    /// shaders are chosen by.
    pub(crate) casters: Vec<(Identity, Aabb)>,
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

/// The passes into each place, in order.
pub(crate) type Drawn = BTreeMap<Place, Vec<Record>>;

/// Places that a pass writes and reads.
#[derive(Clone, Debug, Default)]
pub(crate) struct Touches {
    pub(crate) writes: Vec<Place>,
    pub(crate) reads: BTreeSet<Place>,
}

/// All that was drawn for a light.
#[derive(Default)]
pub(crate) struct Memory {
    pub(crate) textures: Textures,
    /// Buffers that passes write.
    pub(crate) buffers: Buffers,
    /// The bytes that were uploaded.
    pub(crate) contents: BTreeMap<String, Vec<u8>>,
    pub(crate) drawn: Drawn,
    /// The last job, where it ended in a shadow.
    pub(crate) asked: Option<Asked>,
}

impl Memory {
    /// Lets go of what `plan` does not have, and of textures and buffers that were written and that it has no pass for: they
    /// hold what it does not expect.
    pub(crate) fn let_go(&mut self, plan: &ShadowPlan) {
        let written: BTreeSet<_> = plan.passes.iter().flat_map(Pass::writes).collect();
        let drawn = self.drawn.keys().map(|place| &place.0);
        let has = |name: &str| {
            let textures = plan.textures.iter().map(|desc| &desc.name);
            let buffers = plan.buffers.iter().map(|desc| &desc.name);
            textures.chain(buffers).any(|own| own == name)
        };
        let gone = drawn.filter(|name| !written.contains(name.as_str()) || !has(name));
        let gone: BTreeSet<_> = gone.cloned().collect();
        self.textures
            .retain(|name, _| has(name) && !gone.contains(name));
        self.buffers
            .retain(|name, _| has(name) && !gone.contains(name));
        self.drawn.retain(|place, _| !gone.contains(&place.0));
    }
}

/// The passes into each place.
pub(crate) fn by_place(passes: &[(Record, Touches)]) -> Drawn {
    let mut all = Drawn::new();
    for (record, touches) in passes {
        for place in &touches.writes {
            all.entry(place.clone()).or_default().push(record.clone());
        }
    }
    all
}

/// Which passes of a plan have to be run, in its order, where these stand. `new` has the textures and buffers that hold
/// nothing yet or were uploaded anew.
pub(crate) fn stale(
    passes: &[(Record, Touches)],
    (wanted, drawn): (&Drawn, &Drawn),
    new: &BTreeSet<String>,
) -> Vec<bool> {
    let mut stale: BTreeSet<&Place> = wanted
        .iter()
        .filter(|(place, records)| new.contains(&place.0) || drawn.get(*place) != Some(*records))
        .map(|(place, _)| place)
        .collect();
    // A place that is filled again has what is made of it filled again, and all that one pass writes goes together. A place that
    // later passes fill further has lost what a pass before them reads.
    loop {
        let before = stale.len();
        for (number, (_, Touches { writes, reads })) in passes.iter().enumerate() {
            let fresh = |place: &Place| new.contains(&place.0) || stale.contains(place);
            if !writes.iter().any(|place| stale.contains(place)) && !reads.iter().any(fresh) {
                continue;
            }
            let later = passes[number + 1..]
                .iter()
                .flat_map(|(_, later)| &later.writes);
            let lost = later.filter(|place| reads.contains(*place));
            stale.extend(writes.iter().chain(lost));
        }
        if stale.len() == before {
            break;
        }
    }
    let runs = |(_, touches): &(Record, Touches)| touches.writes.iter().any(|w| stale.contains(w));
    passes.iter().map(runs).collect()
}

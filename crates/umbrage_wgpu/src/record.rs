//! Records of what stands in a plan's textures, so that nothing is drawn that stands already.

use std::{
    collections::{BTreeMap, BTreeSet, HashMap},
    sync::Arc,
};

use glam::DVec3;
use umbrage_compose::ProjectedKey;
use umbrage_shadow::{
    Aabb, Blend, BufferDesc, CasterPass, Constants, Pass, SamplerDesc, ShadowPlan,
};

use crate::{
    Identity,
    area::{Area, Shadower},
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
pub(crate) type Drawn = BTreeMap<Place, Vec<Arc<Record>>>;

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
pub(crate) fn by_place(passes: &[Ready]) -> Drawn {
    let mut all = Drawn::new();
    for (record, touches) in passes {
        for place in &touches.writes {
            let records = all.entry(place.clone()).or_default();
            records.push(Arc::clone(record));
        }
    }
    all
}

/// A pass with all that it depends on and touches.
pub(crate) type Ready = (Arc<Record>, Touches);

/// Work that a pass is for what stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Work {
    /// None: what it would fill stands.
    Nothing,
    /// It draws what lies in an area of its targets.
    Repair(Area),
    /// All of it.
    Whole,
}

/// Work of each of a plan's passes, in its order, where these stand. `new` has the textures and buffers that hold
/// nothing yet or were uploaded anew.
pub(crate) fn work(
    passes: &[Ready],
    (wanted, drawn): (&Drawn, &Drawn),
    new: &BTreeSet<String>,
) -> Vec<Work> {
    let mut areas = vec![None; passes.len()];
    // Places that are filled anew as a whole.
    let mut stale = BTreeSet::new();
    for (place, records) in wanted {
        let before = drawn.get(place).filter(|_| !new.contains(&place.0));
        if before == Some(records) {
            continue;
        }
        let writers = writers(passes, place);
        match before.and_then(|before| moved(before, records)) {
            Some(changed) => {
                for (writer, area) in writers.into_iter().zip(changed) {
                    areas[writer] = area;
                }
            }
            None => {
                stale.insert(place);
            }
        }
    }
    // A pass that empties a part of one place empties it of all its places.
    for (i, (_, touches)) in passes.iter().enumerate() {
        let mut all = touches.writes.iter().map(|place| writers(passes, place));
        let first = all.next();
        if areas[i].is_some() && all.any(|other| Some(other) != first) {
            stale.extend(&touches.writes);
        }
    }
    // A place that is filled again has what is made of it filled again, and all that one pass writes goes together. A place that
    // later passes fill further has lost what a pass before them reads.
    loop {
        let before = stale.len();
        for (number, (_, Touches { writes, reads })) in passes.iter().enumerate() {
            let repaired = |place: &Place| {
                let mut writers = passes.iter().zip(&areas);
                writers.any(|((_, writer), area)| area.is_some() && writer.writes.contains(place))
            };
            let fresh =
                |place: &Place| new.contains(&place.0) || stale.contains(place) || repaired(place);
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
    let work = |((_, touches), area): (&Ready, &Option<Area>)| {
        let whole = touches.writes.iter().any(|place| stale.contains(place));
        match (whole, area) {
            (true, _) => Work::Whole,
            (false, Some(area)) => Work::Repair(*area),
            (false, None) => Work::Nothing,
        }
    };
    passes.iter().zip(&areas).map(work).collect()
}

/// The passes into a place.
fn writers(passes: &[Ready], place: &Place) -> Vec<usize> {
    let writes = |i: &usize| passes[*i].1.writes.contains(place);
    (0..passes.len()).filter(writes).collect()
}

/// The areas in which the passes into a place differ from those `before`, where some casters are others and nothing else is;
/// none where the place is to be filled anew. Passes into one viewport are repaired in the same area, the first one of them
/// empties it.
fn moved(before: &[Arc<Record>], now: &[Arc<Record>]) -> Option<Vec<Option<Area>>> {
    if before.len() != now.len() {
        return None;
    }
    let pairs = before.iter().zip(now);
    let changed = pairs.map(|(before, now)| before.moved(now));
    let mut areas = changed.collect::<Option<Vec<_>>>()?;
    let viewports = now.iter().map(|record| match &record.pass {
        Pass::Casters(pass) => Area::of(&pass.viewport),
        _ => Area::NOWHERE,
    });
    let viewports: Vec<_> = viewports.collect();
    for (i, one) in viewports.iter().enumerate() {
        for (j, other) in viewports.iter().enumerate().skip(i + 1) {
            if !one.meets(*other) || (areas[i].is_none() && areas[j].is_none()) {
                continue;
            }
            if one != other {
                return None;
            }
            let both = areas[i].into_iter().chain(areas[j]).reduce(Area::union);
            let same = |place: usize| viewports[place] == *one;
            (0..areas.len())
                .filter(|p| same(*p))
                .for_each(|p| areas[p] = both);
        }
    }
    Some(areas)
}

impl Record {
    /// The area in which casters differ in `now`, where nothing else does and it can be drawn by itself: none in it where
    /// they are the same.
    fn moved(&self, now: &Self) -> Option<Option<Area>> {
        let (Pass::Casters(before), Pass::Casters(pass)) = (&self.pass, &now.pass) else {
            return None;
        };
        let alike = self.origin == now.origin
            && self.choices == now.choices
            && CasterPass {
                casters: Vec::new(),
                ..before.clone()
            } == CasterPass {
                casters: Vec::new(),
                ..pass.clone()
            };
        // The order of what is drawn must have no say in what stands, nor may all be emptied half-way.
        let clears = pass.depth.as_ref().is_some_and(|depth| depth.clears);
        let compares = pass.depth.as_ref().is_some_and(|depth| {
            use wgpu::CompareFunction::{Greater, GreaterEqual, Less, LessEqual};
            matches!(depth.compare, Greater | GreaterEqual | Less | LessEqual)
        });
        let by_depth = compares && pass.colors.is_empty();
        let by_most = pass.colors.iter().all(|color| color.blend == Blend::Max);
        if !alike || clears || !(by_depth || (pass.depth.is_none() && by_most)) {
            return None;
        }
        let shadower = Shadower::new(pass, now.origin);
        let areas = differing(&self.casters, &now.casters);
        let areas = areas.filter_map(|(_, bounds)| shadower.area(bounds));
        Some(areas.reduce(Area::union))
    }
}

/// Casters, and what tells which they are.
type Known = (Identity, Aabb);

/// The casters that are in one list alone. Lists go by the frame's order, so that most are at the same place from the front
/// or from the back.
fn differing<'a>(before: &'a [Known], now: &'a [Known]) -> impl Iterator<Item = &'a Known> {
    let same = |(a, b): &(&Known, &Known)| a == b;
    let front = before.iter().zip(now).take_while(same).count();
    let (before, now) = (&before[front..], &now[front..]);
    let back = before.iter().rev().zip(now.iter().rev()).take_while(same);
    let back = back.count();
    let (before, now) = (&before[..before.len() - back], &now[..now.len() - back]);
    let key = |(identity, _): &Known| *identity;
    let by_key = |list: &'a [Known]| -> HashMap<Identity, &'a Known> {
        list.iter().map(|known| (key(known), known)).collect()
    };
    let others = [by_key(now), by_key(before)];
    let lists = [before, now].into_iter().zip(others);
    lists.flat_map(move |(list, other)| {
        let alone = list
            .iter()
            .filter(move |known| other.get(&key(known)) != Some(known));
        alone.collect::<Vec<_>>()
    })
}

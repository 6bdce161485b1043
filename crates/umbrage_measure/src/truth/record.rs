//! All that is true of a scene's shadows in one picture, and a folder that keeps it.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};
use umbrage_compose::{Kind, Look, Store};
use umbrage_render::Scene;

use super::{Sight, Source, Tracer, TruthError, content::content};

/// All that is true of a scene's shadows in one picture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Truth {
    /// Points that the pixels see.
    pub sight: Sight,
    /// For each light of the scene what [`Tracer::shadow`] finds.
    pub terms: Vec<Vec<Option<f32>>>,
    /// For each light of the scene what [`Tracer::gaps`] finds.
    pub gaps: Vec<Vec<Option<f64>>>,
}

/// A folder that keeps truths by the hash of all that they depend on, the tracer included.
#[derive(Debug)]
pub struct TruthStore(Store);

/// Of what an entry looks like; the header changes with it.
const KIND: Kind = Kind {
    header: b"umbrage truth 01",
    extension: "truth",
};

impl Truth {
    /// Traces `scene` in a picture of the given size, its lights as large as `sources` has them, in the
    /// scene's order; lights beyond the list's end are sharp. `on_row` is called [`Truth::rows`] times, from
    /// any thread.
    ///
    /// # Errors
    /// As [`Tracer::new`], [`Tracer::look`] and [`Tracer::shadow`].
    pub fn trace(
        scene: &Scene,
        (width, height): (u32, u32),
        sources: &[Source],
        on_row: &(dyn Fn() + Sync),
    ) -> Result<Self, TruthError> {
        let tracer = Tracer::new(scene)?;
        let sight = tracer.look(width, height, on_row)?;
        let lights = 0..scene.lights.len();
        let source = |light: usize| sources.get(light).copied().unwrap_or_default();
        let shadow = |light| tracer.shadow(&sight, light, source(light), on_row);
        let gaps = |light| tracer.gaps(&sight, light, on_row);
        let terms = lights.clone().map(shadow).collect::<Result<_, _>>()?;
        let gaps = lights.map(gaps).collect::<Result<_, _>>()?;
        Ok(Self { sight, terms, gaps })
    }

    /// The truth in the light of some of the lights alone, by their places in the scene.
    pub(crate) fn lit_by(&self, lights: &[usize]) -> Self {
        Self {
            sight: self.sight.clone(),
            terms: lights
                .iter()
                .map(|light| self.terms[*light].clone())
                .collect(),
            gaps: lights
                .iter()
                .map(|light| self.gaps[*light].clone())
                .collect(),
        }
    }

    /// How many rows of pixels [`Truth::trace`] goes through for a picture `height` pixels high.
    pub fn rows(scene: &Scene, height: u32) -> usize {
        height as usize * (1 + 2 * scene.lights.len())
    }
}

impl TruthStore {
    /// The store in the folder `dir`, which is made where it is missing.
    ///
    /// # Errors
    /// A folder that cannot be made or written to.
    pub fn open(dir: impl Into<PathBuf>) -> Result<Self, umbrage_compose::Error> {
        Store::open(dir, KIND).map(Self)
    }

    /// The truth as it is kept, or else as [`Truth::trace`] finds it, kept for the next time; and warnings
    /// of entries that were damaged or cannot be written.
    ///
    /// # Errors
    /// As [`Truth::trace`].
    pub fn truth(
        &self,
        scene: &Scene,
        size: (u32, u32),
        sources: &[Source],
        on_row: &(dyn Fn() + Sync),
    ) -> Result<(Truth, Vec<String>), TruthError> {
        let name = content(scene, size, sources);
        let mut warnings = Vec::new();
        match self.0.look(&name, |payload| decode(payload, scene, size)) {
            Look::Found(truth) => return Ok((truth, warnings)),
            Look::Missing => {}
            Look::Dropped(warning) => warnings.push(warning),
        }
        let truth = Truth::trace(scene, size, sources, on_row)?;
        match postcard::to_stdvec(&truth) {
            Ok(payload) => warnings.extend(self.0.keep(&name, &payload)),
            Err(error) => warnings.push(format!("a truth cannot be kept: {error}")),
        }
        Ok((truth, warnings))
    }
}

fn decode(payload: &[u8], scene: &Scene, size: (u32, u32)) -> Result<Truth, &'static str> {
    let truth: Truth = postcard::from_bytes(payload).map_err(|_| "it cannot be decoded")?;
    let pixels = size.0 as usize * size.1 as usize;
    let fits = (truth.sight.width, truth.sight.height) == size
        && truth.sight.seen.len() == pixels
        && truth.terms.len() == scene.lights.len()
        && truth.gaps.len() == scene.lights.len()
        && truth.terms.iter().all(|terms| terms.len() == pixels)
        && truth.gaps.iter().all(|gaps| gaps.len() == pixels);
    fits.then_some(truth).ok_or("it is of another picture")
}
